"""The scripts of examples/python run, each in a folder of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import octant

ROOT = Path(__file__).parents[2]
SCRIPTS = sorted((ROOT / "examples" / "python").glob("*.py"))


@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: path.stem)
def test_script(script, tmp_path):
    # The package that is tested, whose kernels are compiled already.
    package = str(Path(octant.__file__).parents[1])
    environment = {**os.environ, "PYTHONPATH": os.environ.get("PYTHONPATH", package)}
    call = [sys.executable, str(script)]
    done = subprocess.run(
        call, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
