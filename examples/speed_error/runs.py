"""What to run, and the running of it: scenes, methods, records."""
import csv
import json
import os
import re
import subprocess
import tempfile
from dataclasses import dataclass, field

EXAMPLES = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
GENERATED = [os.path.join(EXAMPLES, name) for name in
             ("scenes/stretch.yaml", "scenes/twist.yaml", "scenes/compression.yaml", "knot.yaml")]


@dataclass(frozen=True)
class Scene:
    """An option file with options that come after it; `paper` is the row of the paper's results."""
    name: str
    options: tuple
    paper: dict = field(default=None, compare=False)


@dataclass(frozen=True)
class Method:
    """How a scene is solved. `tolerance`: of -snes_trefoil_energy_tolerance, None: as the scene
    says."""
    rule: str
    guess: str
    search: str
    tolerance: float = None

    @property
    def name(self):
        return f"{self.rule} {self.guess} {self.search}"

    def options(self):
        stop = [] if self.tolerance is None else [
            "-snes_trefoil_energy_tolerance", repr(self.tolerance),
            "-snes_trefoil_decrement_tolerance", "0"]
        return ["-snes_trefoil_filter", self.rule, "-initial", self.guess,
                "-snes_trefoil_search", self.search, *stop]


def scenes_from_files(files, poisson_ratios, options=()):
    """Every file with every Poisson ratio; without ratios as the file has it."""
    scenes = []
    for file in files:
        name = os.path.splitext(os.path.basename(file))[0]
        for ratio in poisson_ratios or [None]:
            more = [] if ratio is None else ["-material_poisson", ratio]
            scenes.append(Scene(name if ratio is None else f"{name} {ratio}",
                                ("-options_file", file, *more, *options)))
    return scenes


def paper_results(folder):
    return os.path.join(folder, "reference", "official.csv")


def paper_scenes(folder):
    """The scenes of folder/reference/official.csv for which examples/paper has an option file, and
    the names of those for which it has none."""
    scenes, missing = [], []
    with open(paper_results(folder), encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["strategy"] == "adaptive"]
    for row in rows:
        options = os.path.join(EXAMPLES, "paper", row["experiment"] + ".yaml")
        meshes = [os.path.join(folder, "meshes", row["mesh"] + end) for end in (".mesh", ".msh")]
        mesh = next((path for path in meshes if os.path.exists(path)), None)
        if mesh and os.path.exists(options):
            scenes.append(Scene(row["experiment"],
                                ("-options_file", options, "-mesh_file", mesh), row))
        else:
            missing.append(row["experiment"])
    return scenes, missing


def environment():
    """Open MPI as root and with more ranks than cores; one thread a rank."""
    return dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_mpi_yield_when_idle="1",
                OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")


class Runner:
    """Runs scenes by methods and keeps the fastest record of each pair in a folder."""

    def __init__(self, program, ranks, options, folder, reuse, timeout):
        self.program, self.ranks, self.options = program, ranks, list(options)
        self.folder, self.reuse, self.timeout = folder, reuse, timeout
        self.complaints = {}  # (scene, method): why there is no record
        os.makedirs(folder, exist_ok=True)

    def path(self, scene, method):
        stop = "" if method.tolerance is None else f" {method.tolerance:g}"
        words = f"{scene.name} {method.name}{stop} {self.ranks}"
        return os.path.join(self.folder, re.sub(r"[^\w.-]+", "_", words) + ".json")

    def run_all(self, scenes, methods, repeats, report=print):
        """Methods take turns on a scene, so that a machine's moods spread over all of them."""
        records = {}
        for scene in scenes:
            for repeat in range(repeats):
                for method in methods:
                    record = self.run(scene, method, fresh=repeat > 0)
                    records[scene, method] = record
                    report(f"{scene.name:24s} {method.name:32s} "
                           + self.summary(scene, method, record))
        return records

    def summary(self, scene, method, record):
        if record is None:
            return self.complaints.get((scene, method), "no record")
        result = record["result"]
        return (f"{result['iterations']:4d} iterations {record['history'][-1]['seconds']:8.2f} s  "
                + ("converged" if result["converged"] else "NOT CONVERGED: " + result["reason"]))

    def run(self, scene, method, fresh=False):
        """The fastest record so far; None where the program gave none."""
        path = self.path(scene, method)
        known = read(path) if self.reuse or fresh else None
        if known and known.get("command") != self.command(scene, method):
            known = None  # that of another scene or method under the same name
        if known and not fresh:
            return known
        record = self.run_once(scene, method)
        if record is None:
            return known
        if known and seconds(known) <= seconds(record):
            return known
        record["command"] = self.command(scene, method)
        with open(path + ".part", "w", encoding="utf-8") as file:
            json.dump(record, file)
        os.replace(path + ".part", path)
        return record

    def command(self, scene, method):
        """What makes the run, the program itself and its output aside."""
        return [*scene.options, *method.options(), *self.options]

    def run_once(self, scene, method):
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "record.json")
            command = [self.program, *self.command(scene, method),
                       "-output_file", os.path.join(folder, "fields.xdmf"),
                       "-snes_trefoil_monitor", "false", "-snes_trefoil_record", file]
            if self.ranks > 1:
                command = ["mpirun", "-n", str(self.ranks), *command]
            try:
                result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                        text=True, env=environment(), timeout=self.timeout,
                                        check=False)
            except subprocess.TimeoutExpired:
                self.complaints[scene, method] = f"not finished in {self.timeout:g} s"
                return None
            record = read(file)
            if record is None:
                lines = result.stdout.strip().splitlines() or ["no output"]
                self.complaints[scene, method] = f"exit status {result.returncode}: {lines[-1]}"
            return record


def read(path):
    if not os.path.exists(path):
        return None
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def seconds(record):
    return record["history"][-1]["seconds"]


def rules_of(program, options=()):
    """The rules that the program knows, with what these options load, from its help; `constant`,
    which wants a weight, is left out."""
    text = subprocess.run([program, "-options_file", GENERATED[0], *options, "-help"],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          env=environment(), check=False).stdout
    found = re.search(r"-snes_trefoil_filter <[^>]*>:? Filter of the element Hessians: ([\w, ]+)[\n(]",
                      text)
    if not found:
        raise SystemExit(f"speed_against_error: {program} does not tell its filters:\n{text}")
    return [name.strip() for name in found.group(1).split(",") if name.strip() != "constant"]
