"""Runs the program for the scene tests."""
import json
import os
import re
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("TREFOIL", os.path.join(ROOT, "build", "trefoil"))


def environment():
    """Open MPI as root and with more ranks than cores; one thread a rank."""
    return dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                OMPI_MCA_rmaps_base_oversubscribe="1", OMPI_MCA_mpi_yield_when_idle="1")


def run(options, ranks=1, folder=None):
    """The finished process; `options` is a string or a list of words."""
    words = options.split() if isinstance(options, str) else list(options)
    command = ["mpirun", "-n", str(ranks), PROGRAM, *words] if ranks > 1 else [PROGRAM, *words]
    return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=300, cwd=folder, env=environment(), check=False)


MEASURED = """
import os, resource, subprocess, sys
done = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL, check=False)
peak = 1024 * resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
os.write(1, f"rank {os.environ['OMPI_COMM_WORLD_RANK']} {done.returncode} {peak}\\n".encode())
"""


def peaks_of(options, ranks):
    """The most bytes that each rank of a run has held, by rank."""
    command = ["mpirun", "-n", str(ranks), sys.executable, "-c", MEASURED, PROGRAM, *options]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=300, env=environment(), check=False)
    lines = re.findall(r"^rank (\d+) (\d+) (\d+)$", done.stdout, re.M)
    if len(lines) != ranks or any(status != "0" for _, status, _ in lines):
        raise AssertionError(done.stdout)
    return [int(peak) for _, _, peak in sorted(lines, key=lambda line: int(line[0]))]


def refusal_of(options, ranks=1):
    """The one sentence with which a run ends as bad input."""
    refused = run(options, ranks)
    sentences = [line for line in refused.stdout.splitlines() if line.startswith("trefoil: ")]
    if refused.returncode != 1 or len(sentences) != 1:
        raise AssertionError(f"no refusal in one sentence, exit {refused.returncode}:\n"
                             f"{refused.stdout}")
    return sentences[0]


def record_of(options, ranks=1):
    """The JSON record of a run, with its exit status under `status`."""
    words = options.split() if isinstance(options, str) else list(options)
    with tempfile.TemporaryDirectory() as folder:
        result = run([*words, "-snes_trefoil_record", "record.json"], ranks, folder)
        path = os.path.join(folder, "record.json")
        if not os.path.exists(path):
            raise AssertionError(f"no record from {' '.join(words)}:\n{result.stdout}")
        with open(path, encoding="utf-8") as file:
            record = json.load(file)
    record["status"] = result.returncode
    record["printed"] = result.stdout
    return record
