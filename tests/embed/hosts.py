"""Runs programs that know nothing of Trefoil, with the plugin loaded by an option."""
import json
import os
import re
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LIBRARY = os.environ.get("TREFOIL_LIBRARY", os.path.join(ROOT, "build", "libtrefoil.so"))
HOSTS = os.environ.get("TREFOIL_HOSTS", os.path.join(ROOT, "build", "tests", "embed"))
DIRECT = "-ksp_type preonly -pc_type lu -pc_factor_mat_solver_type mumps"
LOAD = f"-dll_append {LIBRARY}"
TREFOIL = f"{LOAD} -snes_type trefoil"


def run(program, options, ranks=1, variables=None):
    """What a program printed, and its exit status. `program` is a list of words."""
    environment = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                       OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_mpi_yield_when_idle="1",
                       OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", **(variables or {}))
    with tempfile.TemporaryDirectory() as folder:
        environment["HOME"] = environment["XDG_CACHE_HOME"] = folder
        result = subprocess.run(["mpirun", "-n", str(ranks), *program, *options.split()],
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                timeout=300, cwd=folder, env=environment, check=False)
        record = None
        if os.path.exists(os.path.join(folder, "record.json")):
            with open(os.path.join(folder, "record.json"), encoding="utf-8") as file:
                record = json.load(file)
    return result.stdout, result.returncode, record


def outcome(printed):
    """The closing line of our examples: converged?, iterations, and the number that they print."""
    found = re.search(r"(\w+) iterations (\d+) (?:energy|norm) (\S+)", printed)
    assert found, printed[-2000:]
    return found[1].startswith("CONVERGED"), int(found[2]), float(found[3])


def sentence(printed):
    """The sentence of a PETSc error: the line after its title."""
    found = re.search(r"PETSC ERROR: -+ Error Message -+\n\[\d+\]PETSC ERROR: .*\n"
                      r"\[\d+\]PETSC ERROR: (.*)", printed)
    return found[1] if found else printed[-2000:]
