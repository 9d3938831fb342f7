"""The numbers of every verb in short runs, as digests, so that no change moves one unnoticed.

``python tests/regression/golden.py`` (with Octant importable) runs every case and writes
``golden.json`` anew: for each file that a case leaves, each column or variable with its shape, the
first 16 digits of the SHA-256 of its bytes and a few of its values.
"""

import contextlib
import csv
import hashlib
import io
import json
import math
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
EXAMPLES = HERE.parents[1] / "examples"
GOLDEN = HERE / "golden.json"
SAMPLES = 4
LEFT_OUT = re.compile(r"seconds|^offline_s$|_us$|^file_sha256$|^(cell_)?key$|^cell$")
"""Measured times, which no run repeats, and the names of files by their content and input."""

# Each case: the command line, {file of the copied examples: {old line: new line}}, and the pattern
# of the files to digest. The copy of examples/ is the working folder.
COARSE = "cells_per_wavelength = 5.0"
CASES = {
    "study thesis": (["study", "thesis", "--quick", "--out", "out"], {}),
    "study office": (
        ["study", "l_shaped_office.toml", "--quick", "--out", "out"],
        {},
    ),
    "study best reader": (
        ["study", "best_reader.toml", "--quick", "--out", "out"],
        {"best_reader.toml": {"samples = 24": "samples = 2", 'response = "fullwave"': COARSE}},
    ),
    "sweep": (
        ["sweep", "sweep_gap_and_plane.toml", "--out", "out"],
        {
            "sweep_gap_and_plane.toml": {
                'response = "fullwave"': COARSE,
                "gap_m = [0.005, 0.01, 0.02, 0.03]": "gap_m = [0.005, 0.02]",
            }
        },
    ),
    "sweep in the room": (
        ["sweep", "best_reader.toml", "--out", "out"],
        {
            "best_reader.toml": {
                'response = "fullwave"': COARSE,
                "[map]": "[sweep]\nplate_height_m = [0.05, 0.0656]\n[map]",
            }
        },
    ),
    "optimise": (
        ["optimise", "gap_and_shape.toml", "--out", "out"],
        {
            "gap_and_shape.toml": {
                "height_m = 0.30": "height_m = 0.30\n" + COARSE,
                "gap_m = [0.005, 0.01, 0.02, 0.03]": "gap_m = [0.005, 0.02]",
            }
        },
    ),
    "optimise by search": (
        ["optimise", "compact_reader.toml", "--out", "out"],
        {
            "compact_reader.toml": {
                "cells_per_wavelength = 10.0": COARSE,
                "confirm_cells_per_wavelength = 14.0": "confirm_cells_per_wavelength = 6.0",
                "survey = 9": "survey = 2",
                "starts = 2": "starts = 1",
                "evaluations = 45": "evaluations = 5",
            }
        },
    ),
    "tolerance": (
        ["tolerance", "best_reader.toml", "--samples", "3", "--out", "out"],
        {"best_reader.toml": {'response = "fullwave"': COARSE}},
    ),
    "track built-in": (
        ["track", "track.toml", "--out", "out"],
        {},
    ),
    "track laboratory": (
        ["track", "track_laboratory.toml", "--out", "out"],
        {"track_laboratory.toml": {"runs = 20": "runs = 2"}},
    ),
    "track further": (
        ["track", "track_further.toml", "--out", "out"],
        {
            "track_further.toml": {
                "\nruns = 20": "\nruns = 2",
                "slam_runs = 100": "slam_runs = 3",
                '"law", "long", "stabilisation"': '"law"',
                '"laboratory", "reader"': '"laboratory"',
            }
        },
    ),
    "dock built-in": (["dock", "--runs", "2", "--out", "out"], {}),
    "dock office": (["dock", "docking_office.toml", "--runs", "2", "--out", "out"], {}),
    "compare": (["navigate", "layouts/short.toml", "--compare", "--out", "out"], {}),
    "map": (
        ["map", "l_shaped_office.toml", "--out", "out/map.nc", "--spreads"],
        {},
    ),
    "map of the mean": (
        ["map", "layouts/store_room.toml", "--out", "out/map.nc", "--local-mean"],
        {},
    ),
    "map of passive tags": (
        ["map", "passive_uhf.toml", "--out", "out/map.nc"],
        {"passive_uhf.toml": {"spacing_m = 0.1": "spacing_m = 0.5"}},
    ),
    "paths": (
        [
            "paths", "l_shaped_office.toml", "--tx", "2.0,0.5,2.5", "--rx", "1.0,1.2,0.4",
            "--rx", "3.1,0.2,0.9", "--csv", "out/paths.csv",
        ],
        {},
    ),
    "simulate-log": (
        [
            "simulate-log", "demo", "--out", "out/log.csv", "--way", "floor", "--spacing-m", "1.5",
            "--step-m", "0.5", "--noise-db", "1",
        ],
        {},
    ),
    "replay": (
        ["replay", "demo", "--log", "short_log.csv", "--estimator", "tracker", "--out", "out"],
        {},
    ),
    "reader": (["reader", "best_reader.toml", "--out", "out", "--step-deg", "10"], {}),
    **{
        f"navigate {name}": (
            ["navigate", f"layouts/{name}.toml", "--runs", "2", "--out", "out"],
            {},
        )
        for name in (
            "open_space", "open_cabinet", "open_objects", "concrete_room", "concrete_cabinet",
            "concrete_objects", "concrete_room_arriving", "corridor", "store_room",
        )
    },
}  # fmt: skip

SHORT_COMPARISON = """\
name = "short"
seed = 1
runs = 2
[[layout]]
study = "open_space.toml"
[[layout]]
study = "concrete_cabinet.toml"
[[link]]
name = "dipole"
radio.channels_hz = []
tag.antenna = "dipole"
[[controller]]
name = "thesis"
mission = { navigator = "thesis", controller = "fuzzy" }
[[controller]]
name = "tracker"
mission = { navigator = "tracker" }
"""
SHORT_TRACK = """\
name = "thesis-tracking"
seed = 1
[room]
box_m = [12.0, 12.0, 3.0]
origin_m = [-6.0, -6.0, 0.0]
material = "concrete"
[track]
runs = 2
slam_runs = 2
"""
SHORT_LOG = "\n".join(
    [
        "time_s,x_m,y_m,heading_deg,distance_m,turn_deg,id,antenna,rss_dbm",
        *(
            f"{k},{1.0 + 0.2 * k},0.8,0,{0.2 * (antenna == 1)},0,door,{antenna},"
            f"{-30.0 + 5.0 * math.cos(math.radians(45.0 * (antenna - 3)))}"
            for k in range(12)
            for antenna in range(1, 9)
        ),
        "12,3.4,0.8,0,0,0,door,3,-inf",
        "",
    ]
)


def examples_for(name, folder):
    """Return a copy of the examples below a folder, shortened as a case wants it."""
    work = folder / "examples"
    shutil.copytree(EXAMPLES, work)
    (work / "track.toml").write_text(SHORT_TRACK)
    (work / "layouts" / "short.toml").write_text(SHORT_COMPARISON)
    (work / "short_log.csv").write_text(SHORT_LOG)
    for file, lines in CASES[name][1].items():
        text = (work / file).read_text()
        for old, new in lines.items():
            assert old in text, f"{file} has no line {old!r}"
            text = text.replace(old, new)
        (work / file).write_text(text)
    return work


def run_case(name, folder):
    """Run one case in a copy of the examples below a folder; return where its files lie."""
    from octant.reader_design.cli import run

    command, _ = CASES[name]
    work = examples_for(name, folder)
    before = Path.cwd()
    os.chdir(work)
    try:
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            code = run([*command, "--quiet"])
        assert code == 0, f"{name}: exit code {code}: {said.getvalue()}"
    finally:
        os.chdir(before)
    return work / "out"


def digest(values):
    """Return shape, hash and a few values of one column or variable."""
    array = np.asarray(values)
    if array.dtype.kind in "OUS":
        texts = [str(v) for v in array.ravel()]
        return {
            "shape": list(array.shape),
            "sha256": hashlib.sha256("\0".join(texts).encode()).hexdigest()[:16],
        }
    array = np.ascontiguousarray(array.astype(np.float64))
    flat = array.ravel()
    picked = flat[:: max(1, flat.size // SAMPLES)][:SAMPLES]
    return {
        "shape": list(array.shape),
        "sha256": hashlib.sha256(array.tobytes()).hexdigest()[:16],
        "values": [float(v) if np.isfinite(v) else str(v) for v in picked],
    }


def table(path):
    """Return the columns of a CSV file: numbers where all are, else texts."""
    with path.open(newline="") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    head, rows = rows[0], rows[1:]
    columns = {}
    for i, name in enumerate(head):
        cells = [row[i] if i < len(row) else "" for row in rows]
        try:
            columns[name] = np.array([float(c) if c else np.nan for c in cells])
        except ValueError:
            columns[name] = np.array(cells)
    return columns


def contents(folder):
    """Return {file: {variable: digest}} of the tables and netCDF files of a folder."""
    import xarray as xr

    found = {}
    for path in sorted(folder.glob("*")):
        if path.suffix == ".csv":
            columns = table(path)
        elif path.suffix == ".nc":
            with xr.open_dataset(path, engine="h5netcdf") as data:
                columns = {str(k): v.to_numpy() for k, v in data.variables.items()}
        else:
            continue
        found[path.name] = {
            name: digest(values) for name, values in columns.items() if not LEFT_OUT.search(name)
        }
    return found


def machine():
    """Return what decides the last bits: processor, BLAS kernel, versions of the libraries."""
    import llvmlite.binding
    import numba
    import scipy
    import threadpoolctl

    blas = {str(i.get("architecture")) for i in threadpoolctl.threadpool_info() if "blas" in str(i)}
    return {
        "processor": llvmlite.binding.get_host_cpu_name(),
        "blas": sorted(blas),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "numba": numba.__version__,
    }


def main(names):
    """Run the named cases, or all, and write what they leave into golden.json."""
    golden = json.loads(GOLDEN.read_text()) if GOLDEN.exists() and names else {"cases": {}}
    golden["machine"] = machine()
    for name in names or CASES:
        with tempfile.TemporaryDirectory() as folder:
            golden["cases"][name] = contents(run_case(name, Path(folder)))
        GOLDEN.write_text(json.dumps(golden, separators=(",", ":"), sort_keys=True) + "\n")
        sys.stderr.write(f"{name}: {sum(map(len, golden['cases'][name].values()))} variables\n")


if __name__ == "__main__":
    main(sys.argv[1:])
