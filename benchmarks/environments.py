"""The peers' own environments: made once in a cache folder, one each, and run as processes."""

import ctypes.util
import json
import os
import re
import subprocess
import sys
import venv
from pathlib import Path

import numpy as np

PEERS = {
    "sionna": ("Sionna RT", "sionna_run.py", ("sionna-rt==2.2.0",)),
    "differt": ("DiffeRT", "differt_run.py", ("differt[cpu]==0.12.0",)),
    "pyroom": ("pyroomacoustics", "pyroom_run.py", ("pyroomacoustics==0.10.1",)),
}
"""Name in the table, script, and what is installed."""

SCRIPTS = Path(__file__).resolve().parent / "peers"
OLDEST_LLVM = 16


def default_folder():
    """Return where environments are kept unless the command line says otherwise."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return cache / "octant-peers"


def environment(peer, folder):
    """Return the Python of a peer's environment, which is made if it is not there."""
    here = folder / peer
    python = here / "bin" / "python"
    done = here / "installed.txt"
    wanted = "\n".join(PEERS[peer][2])
    if not done.is_file() or done.read_text() != wanted:
        print(f"making the environment of {PEERS[peer][0]} in {here}", file=sys.stderr)
        venv.create(here, with_pip=True, clear=True)
        subprocess.run(
            [python, "-m", "pip", "install", "--quiet", *PEERS[peer][2]],
            check=True,
            stdout=sys.stderr,
        )
        done.write_text(wanted)
    return python


def llvm_library():
    """Return the file of LLVM's shared library of version 16 or newer, or None."""
    given = os.environ.get("DRJIT_LIBLLVM_PATH")
    if given:
        return given
    listed = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True, check=False).stdout
    found = re.findall(r"libLLVM[.-](?:so\.)?(\d+)\S* .*=> (\S+)", listed)
    new = [(int(version), file) for version, file in found if int(version) >= OLDEST_LLVM]
    return max(new)[1] if new else ctypes.util.find_library(f"LLVM-{OLDEST_LLVM}")


class Peer:
    """One peer's process on one workload; it is asked for one run at a time."""

    def __init__(self, peer, workload_file, folder):
        self.name = PEERS[peer][0]
        variables = dict(os.environ)
        variables.pop("PYTHONPATH", None)
        if peer == "sionna":
            library = llvm_library()
            if library is None:
                message = (
                    "Sionna RT needs LLVM's shared library, version 16 or newer: install it "
                    "(Debian: libllvm19) or set DRJIT_LIBLLVM_PATH to its file."
                )
                raise SystemExit(message)
            variables["DRJIT_LIBLLVM_PATH"] = library
        self._log = Path(workload_file).with_suffix(f".{peer}.log")
        with self._log.open("w") as log:
            self._process = subprocess.Popen(
                [environment(peer, folder), SCRIPTS / PEERS[peer][1], workload_file],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                env=variables,
            )
        self._answer()

    def _answer(self):
        line = self._process.stdout.readline()
        if not line:
            lines = self._log.read_text().splitlines()
            raise SystemExit(f"{self.name} stopped: {lines[-1] if lines else 'without a word'}")
        return json.loads(line)

    def _ask(self, words):
        self._process.stdin.write(words + "\n")
        self._process.stdin.flush()
        return self._answer()

    def run(self):
        """Return seconds, seconds of all cores, and greatest memory [MiB] of one run."""
        answer = self._ask("run")
        return np.array([answer["seconds"], answer["cpu_seconds"], answer["peak_mib"]])

    def save(self, file):
        """Write the results of the last run."""
        self._ask(f"save {file}")

    def close(self):
        """End the process."""
        self._process.stdin.close()
        self._process.wait()
