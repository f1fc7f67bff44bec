"""Runs Trefoil from Python, and reads what it wrote. One file; it needs numpy and h5py.

    import trefoil

    result = trefoil.run("examples/knot.yaml", ranks=2, material_poisson=0.3)
    result.record["result"]["energy"]             # the JSON record, as it is
    result.fields["displacement"]                 # vertices x 3, of the last step
    for step in result.steps:                     # one a load or time step
        print(step.t, abs(step.fields["displacement"]).max())

A scene is a path, a text in YAML, or a dictionary of the same shape:

    trefoil.run({"mesh": {"generate": "box"}, "constraints": ..., "load": ...}, order=2)

Options are those of the command line without their dash, and win over the scene. What the program
refuses is raised as `TrefoilError`, with its sentence. Debian: python3-numpy python3-h5py
"""

import collections.abc
import json
import os
import shutil
import subprocess
import tempfile
import weakref
import xml.etree.ElementTree

import h5py
import numpy as np

NOT_CONVERGED = 3  # exit status of the program


class TrefoilError(RuntimeError):
    """A run that was refused; its text is the program's sentence."""


class NotConverged(TrefoilError):
    """A run that ended without an equilibrium; `result` is the state in which it ended."""

    def __init__(self, sentence, result):
        super().__init__(sentence)
        self.result = result


class Fields(collections.abc.Mapping):
    """Fields by name, read from the file at each look."""

    def __init__(self, file, elements):
        self._file, self._elements = file, elements

    def __getitem__(self, name):
        return self._file.read(self._elements[name])

    def __iter__(self):
        return iter(self._elements)

    def __len__(self):
        return len(self._elements)

    def on_vertices(self, name):
        """Whether the field has a row a vertex; otherwise it has one a cell."""
        return self._elements[name].get("Center") == "Node"

    def __repr__(self):
        return f"Fields({', '.join(self._elements)})"


class Step:
    """One load or time step: `t`, the rest positions `points` (vertices x 3; a flat body has z = 0),
    `cells` (cells x nodes of a cell: 3, 4, 6 or 10; midpoints of edges in VTK's order), and fields:
    `vertex_fields` and `cell_fields` have a row a vertex and a cell; `fields` has all names, on
    vertices where a field is on both."""

    def __init__(self, grid, file, t):
        self.t = t
        self._grid, self._file = grid, file
        centers = {"Node": {}, "Cell": {}}
        for element in grid.findall("Attribute"):
            centers[element.get("Center")][element.get("Name")] = element
        self.vertex_fields, self.cell_fields = (Fields(file, each) for each in centers.values())
        self.fields = Fields(file, {**centers["Node"],
                                    **{name: element for name, element in centers["Cell"].items()
                                       if name not in centers["Node"]}})

    @property
    def points(self):
        return self._file.read(self._grid.find("Geometry"))

    @property
    def cells(self):
        return self._file.read(self._grid.find("Topology"))


class _File:
    """The XDMF file and the HDF5 file beside it. `keep`: something that must live as long."""

    def __init__(self, path, keep=None):
        self.root = xml.etree.ElementTree.parse(path).getroot()
        self._folder = os.path.dirname(path)
        self._keep = keep

    def read(self, element):
        item = element.find("DataItem")
        if item.get("Format", "XML").upper() != "HDF":
            raise ValueError(f"its {element.tag} is not in an HDF5 file")
        name, _, dataset = item.text.strip().partition(":")
        with h5py.File(os.path.join(self._folder, name), "r") as data:
            return data[dataset][()]


def read_steps(path, keep=None):
    """The steps of a file that Trefoil wrote: one, or those of a time series.
    Raises OSError, ValueError or xml.etree.ElementTree.ParseError where it is no such file."""
    file = _File(path, keep)
    domain = file.root.find("Domain")
    grids = [] if domain is None else domain.findall("Grid")
    series = [grid for grid in grids if grid.get("GridType") == "Collection"]
    if series:
        grids = series[0].findall("Grid")
    elif len(grids) > 1:
        grids = grids[:1]
    if not grids:
        raise ValueError("it holds no Domain with a Grid")
    steps = []
    for number, grid in enumerate(grids):
        if grid.find("Geometry") is None or grid.find("Topology") is None:
            raise ValueError(f"its grid {number + 1} has no Geometry or no Topology")
        time = grid.find("Time")
        t = 1.0 if time is None and len(grids) == 1 else number
        steps.append(Step(grid, file, t if time is None else float(time.get("Value"))))
    return steps


def read_obstacles(path):
    """The obstacles of a scene, by name, each as the steps of a file of its own beside that of the
    bodies: points at rest, triangles or segments as cells, and displacements."""
    domain = _File(path).root.find("Domain")
    names = "" if domain is None else domain.get("Obstacles", "")
    stem, ending = os.path.splitext(path)
    return {name: read_steps(f"{stem}.{name}{ending}") for name in names.split()}


class _Scratch:
    """A folder that goes when nothing needs it any more."""

    def __init__(self):
        self.name = tempfile.mkdtemp(prefix="trefoil_")
        weakref.finalize(self, shutil.rmtree, self.name, ignore_errors=True)


class Result:
    """What a run left: `record` (the JSON record), `steps` (none where the output is no .xdmf), `text`
    (what it printed); `points`, `cells` and `fields` are those of the last step."""

    def __init__(self, record, steps, text):
        self.record, self.steps, self.text = record, steps, text

    @property
    def converged(self):
        return bool(self.record["result"]["converged"])

    @property
    def points(self):
        return self.steps[-1].points

    @property
    def cells(self):
        return self.steps[-1].cells

    @property
    def fields(self):
        return self.steps[-1].fields


def find_program():
    """The program: $TREFOIL, the one built in this checkout, or the one that is installed."""
    checkout = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "build", "trefoil")
    for candidate in (os.environ.get("TREFOIL"), os.path.normpath(checkout), shutil.which("trefoil")):
        if candidate and os.access(candidate, os.X_OK):
            return candidate
    raise FileNotFoundError("there is no program trefoil: build it by `sh cmake/setup.sh`, put it "
                            "in the PATH, or name it in the environment variable TREFOIL")


def run(scene, ranks=2, *, folder=None, program=None, timeout=None, **options):
    """Runs a scene and returns its `Result`.

    scene    a path; a text in YAML (more than one line, or "key: value"); or a dictionary. Files that
             it names are relative to the current folder.
    ranks    processes, started by mpirun
    folder   where record.json and fields.xdmf are left; without it they go with the result
    program  path of trefoil, see `find_program`
    timeout  in seconds, after which subprocess.TimeoutExpired is raised
    options  as on the command line: material_poisson=0.3, load_steps=4, constraints=["a", "b"]

    Raises TrefoilError with the program's sentence, NotConverged where no equilibrium was found.
    """
    keep = None if folder else _Scratch()
    folder = folder or keep.name
    os.makedirs(folder, exist_ok=True)
    options = {"snes_trefoil_record": os.path.join(folder, "record.json"),
               "output_file": os.path.join(folder, "fields.xdmf"), **options}
    words = [word for name, value in options.items() for word in ("-" + name, _as_option(value))]
    command = ["mpirun", "-n", str(ranks), program or find_program(), _scene_file(scene, folder), *words]
    for earlier in (options["snes_trefoil_record"], options["output_file"]):
        if os.path.isfile(earlier):
            os.remove(earlier)  # nothing of an earlier run is taken for this one's
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=timeout, env=_environment(), check=False)
    if done.returncode not in (0, NOT_CONVERGED):
        raise TrefoilError(_sentence(done))
    with open(options["snes_trefoil_record"], encoding="utf-8") as file:
        record = json.load(file)
    written = options["output_file"]
    readable = written.endswith(".xdmf") and os.path.exists(written)
    steps = read_steps(written, keep) if readable else []
    result = Result(record, steps, done.stdout)
    if done.returncode == NOT_CONVERGED:
        raise NotConverged(f"not converged: {record['result']['reason']}", result)
    return result


def _as_option(value):
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (list, tuple, np.ndarray)):
        return ",".join(_as_option(each) for each in value)
    return str(value)


def _scene_file(scene, folder):
    """A file that holds the scene."""
    if isinstance(scene, os.PathLike) or (isinstance(scene, str) and os.path.exists(scene)):
        return os.fspath(scene)
    if isinstance(scene, str):
        if "\n" not in scene and ": " not in scene:
            raise FileNotFoundError(f"there is no scene {scene}")
        text = scene
    else:  # JSON is YAML
        text = json.dumps(scene, indent=1, default=lambda value: value.tolist())
    path = os.path.join(folder, "scene.yaml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(text + "\n")
    return path


def _environment():
    """Open MPI refuses to start as root unless told twice, and more ranks than cores unless told."""
    allowed = {"OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_mpi_yield_when_idle": "1"}
    if os.geteuid() == 0:
        allowed.update(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
    return {**allowed, **os.environ}


def _sentence(done):
    """What the program said of its failure; all that was printed where it said nothing."""
    said = [line[len("trefoil: "):] for line in done.stderr.splitlines()
            if line.startswith("trefoil: ")]
    if said:
        return said[0]
    printed = (done.stderr + done.stdout).strip()
    return f"trefoil ended with status {done.returncode}" + (f": {printed}" if printed else "")
