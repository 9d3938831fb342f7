"""Write ``reader_design/kernels.json``: the kernels that each verb needs, in the order of need.

``python tools/list_kernels.py`` runs the verbs on a box with all defaults, and the built-in study;
it takes some minutes. From the list a second process compiles at first use, while
the first one works (`octant.reader_design.compilation`).
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

FILE = Path(__file__).resolve().parents[1] / "reader_design" / "kernels.json"
STUDY = """
[room]
box_m = [5.0, 5.0, 3.0]
[[tag]]
id = "tag"
position_m = [2.0, 0.5, 2.95]
[map]
spacing_m = 0.5
[mission]
tags = ["tag"]
start_m = [3.0, 3.0]
runs = 1
"""
PATHS = ("--tx", "2,0.5,2.95", "--rx", "1,1,0.3")
CALLS = {
    "paths": ("paths", "box.toml", *PATHS),
    "explain": ("explain", "box.toml", *PATHS, "--path", "0"),
    "map": ("map", "box.toml", "--out", "map.nc"),
    "rss": ("rss", "box.toml", "--tag", "tag", "--poses", "poses.csv", "--csv", "rss.csv"),
    "reader": ("reader", "box.toml", "--out", "reader"),
    "navigate": ("navigate", "box.toml", "--out", "navigate", "--workers", "1"),
    "study": ("study", "--out", "study", "--workers", "1"),
}
SAME = {"sweep": "study"}
"""Verbs that need what another one needs."""
PROGRAM = """
import json, sys
from octant.geometries.kernel_list import Recorded
from octant.reader_design.cli import run

with Recorded(json.load(sys.stdin)) as record:
    code = run(sys.argv[1:])
print(json.dumps([record.listed, record.names]))
sys.exit(code)
"""
"""Each verb in a process of its own: what one has loaded another one there would not look for."""


def main() -> None:
    """Write the list."""
    listed, verbs = {"records": {}, "kernels": {}}, {}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "box.toml").write_text(STUDY)
        (Path(folder) / "poses.csv").write_text("x_m,y_m,heading_deg\n3.0,3.0,90.0\n")
        for verb, call in CALLS.items():
            done = subprocess.run(
                [sys.executable, "-c", PROGRAM, *call, "--quiet"],
                cwd=folder,
                env=os.environ | {"OCTANT_CACHE_DIR": folder},
                input=json.dumps(listed),
                stdout=subprocess.PIPE,
                text=True,
                check=True,
            )
            listed, verbs[verb] = json.loads(done.stdout.splitlines()[-1])
    listed["verbs"] = verbs | {verb: verbs[same] for verb, same in SAME.items()}
    FILE.write_text(json.dumps(listed, indent=1) + "\n")


if __name__ == "__main__":
    main()
