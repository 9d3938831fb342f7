"""Whether the lower bounds in pyproject.toml are true: install the lowest versions, run the tests.

``python tools/lowest_versions.py [FOLDER] [-- PYTEST ARGUMENTS]`` makes a virtual environment in
FOLDER (a temporary folder by default), installs Octant with its extra ``test``, the extras that it
holds and every requirement at its lower bound, and runs the default tests there. It uses the Python
that runs it; the oldest one that ``requires-python`` allows is the one to use.
"""

import argparse
import re
import subprocess
import sys
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
REQUIREMENT = re.compile(
    r"(?P<name>[A-Za-z0-9._-]+)(\[[^]]*\])?>=(?P<version>[0-9.]+)(,<[0-9.]+)?$"
)
EXTRAS = ("test", "cluster", "worlds", "bags", "ros", "cad")


def lowest_versions() -> list[str]:
    """Return 'name==version' of every requirement at its lower bound, sorted by name."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = list(project["dependencies"])
    for extra in EXTRAS:
        wanted += project["optional-dependencies"][extra]
    pins = []
    for requirement in wanted:
        if requirement.startswith("octant["):
            continue
        found = REQUIREMENT.match(requirement)
        if found is None:
            raise SystemExit(f"pyproject.toml: {requirement!r} has no lower bound 'name>=version'")
        pins.append(f"{found['name']}=={found['version']}")
    return sorted(pins)


def run_with_lowest(folder: Path, pytest_arguments: list[str]) -> int:
    """Return pytest's exit code in a new environment with the lowest versions.

    Parameters
    ----------
    folder : Path
        Where the environment and the constraints file are written.
    pytest_arguments : list of str
        What pytest is called with.
    """
    folder.mkdir(parents=True, exist_ok=True)
    constraints = folder / "constraints.txt"
    constraints.write_text("\n".join(lowest_versions()) + "\n")
    venv.create(folder / "venv", with_pip=True, clear=True)
    programs = folder / "venv" / "bin"
    pip = [programs / "pip", "--quiet", "--disable-pip-version-check"]
    wanted = f".[{','.join(EXTRAS)}]"
    subprocess.run([*pip, "install", "-c", constraints, wanted], cwd=ROOT, check=True)
    subprocess.run([*pip, "freeze"], check=True)
    tests = [programs / "pytest", *pytest_arguments]
    return subprocess.run(tests, cwd=ROOT, check=False).returncode


def main() -> int:
    """Return the exit code of the tests with the lowest versions."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, help="where the environment is made")
    parser.add_argument("pytest_arguments", nargs="*", default=["-n", "2", "-q"])
    given = parser.parse_args()
    if given.folder is not None:
        return run_with_lowest(given.folder, given.pytest_arguments)
    with tempfile.TemporaryDirectory() as folder:
        return run_with_lowest(Path(folder), given.pytest_arguments)


if __name__ == "__main__":
    sys.exit(main())
