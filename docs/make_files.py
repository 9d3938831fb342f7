"""The page of output files: CSV columns from the code, netCDF variables from small runs.

    python docs/make_files.py FOLDER    run small studies there and keep what their files hold

``conf.py`` writes the page at each build, from the constants that name the columns, from
``columns.toml`` (what they mean) and from ``variables.json`` (what netCDF files hold).
"""

import importlib
import json
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import click

DOCS = Path(__file__).resolve().parent
VARIABLES = DOCS / "variables.json"
HEAD = """# Files and columns

What each verb leaves in its folder, column by column and variable by variable. Each has also
`study.toml`, the study with all defaults written out, most a `report.html` and `figures/`.

A column's unit stands at the end of its name: `_m`, `_s`, `_deg`, `_rad`, `_db`, `_dbm`, `_w`,
`_hz`, `_ohm`; without one it is a number, a share or a name. `_median` is the median over the runs,
`_90` what 90 % of them do not exceed, `_low` and `_high` the ends of the 95 % interval.
Columns are never moved or renamed; new ones come at the end.
"""
EXPERIMENTS = "octant.reader_design.experiments"
LOCALISE = f"{EXPERIMENTS}.missions.localise"
CSV_FILES = (
    ("paths", "--csv FILE", "octant.reader_design.face.paths:PATH_COLUMNS"),
    ("explain", "--csv FILE", "octant.reader_design.face.paths:BUDGET_COLUMNS"),
    ("reader", "band.csv", "octant.reader_design.face.reader_band:BAND_COLUMNS"),
    ("reader", "tilts.csv", "octant.reader_design.face.reader_tilts:TILT_COLUMNS"),
    ("navigate, study", "missions.csv", "octant.navigation.missions.files:MISSION_COLUMNS"),
    ("navigate, study", "trajectory.csv", "octant.navigation.missions.files:TRAJECTORY_COLUMNS"),
    ("navigate", "missions_summary.csv", "octant.navigation.missions.summary:SUMMARY_COLUMNS"),
    ("navigate --localise", "localisation.csv", f"{LOCALISE}:LOCALISATION_COLUMNS"),
    ("navigate --localise", "orientation.csv", f"{LOCALISE}:ORIENTATION_COLUMNS"),
    ("navigate --compare", "compare.csv", f"{EXPERIMENTS}.missions.comparison:COLUMNS"),
    ("navigate, dock, track", "drives/NAME.csv", "octant.reader_design.drives.files:DRIVE_COLUMNS"),
    ("replay", "replay.csv", f"{EXPERIMENTS}.measured.replay_results:REPLAY_COLUMNS"),
    ("replay", "replay_summary.csv", f"{EXPERIMENTS}.measured.replay_results:SUMMARY_COLUMNS"),
    ("simulate-log", "log.csv", "octant.navigation.logs.log_csv:LOG_COLUMNS"),
    ("compare", "compare.csv", f"{EXPERIMENTS}.measured.compare_page:COLUMNS"),
    ("calibrate", "calibrated.csv", f"{EXPERIMENTS}.measured.calibrate_page:COLUMNS"),
    ("tolerance", "tolerance.csv", f"{EXPERIMENTS}.tolerance.results:CSV_HEADER"),
    ("dock", "docking.csv", "octant.navigation.docking.files:DOCKING_COLUMNS"),
    ("dock", "trajectory.csv", "octant.navigation.docking.files:TRAJECTORY_COLUMNS"),
    ("track", "tracking.csv", f"{EXPERIMENTS}.tracking.results:COLUMNS"),
    ("track", "slam.csv", f"{EXPERIMENTS}.tracking.results:SLAM_COLUMNS"),
    ("track", "costs.csv", f"{EXPERIMENTS}.tracking.costs:COST_COLUMNS"),
    ("track", "long.csv", f"{EXPERIMENTS}.tracking.long_drives:LAP_COLUMNS"),
    ("track", "long_trends.csv", f"{EXPERIMENTS}.tracking.long_drives:TREND_COLUMNS"),
    ("track", "horizon.csv", f"{EXPERIMENTS}.tracking.horizons:COLUMNS"),
    ("track", "law.csv", f"{EXPERIMENTS}.tracking.law_on_line:COLUMNS"),
    ("track", "reader.csv", f"{EXPERIMENTS}.tracking.reader_part:COLUMNS"),
    ("track", "stabilisation.csv", f"{EXPERIMENTS}.tracking.stabilisation:COLUMNS"),
    ("track", "frames.csv", f"{EXPERIMENTS}.tracking.frames:COLUMNS"),
    ("track", "laboratory.csv", f"{EXPERIMENTS}.tracking.laboratory:COLUMNS"),
    ("track", "tags.csv", f"{EXPERIMENTS}.tracking.tag_numbers:COLUMNS"),
    ("track", "slam_line.csv", f"{EXPERIMENTS}.tracking.slam_line:COLUMNS"),
)  # fmt: skip
"""CSV files: verb, file, and the constant that names its columns."""
BY_STUDY = """### Tables that follow from the study

| verb | file | columns |
|---|---|---|
| rss | --csv FILE | those of the poses, then `rss_1_w`, `rss_2_w`, ...: antenna by antenna [W] |
| sweep, study | sweep.csv, designs.csv | a row a design: parameters, then [every score](SCORES) |
| optimise | optimise.csv, pareto.csv | a row a design: keys of `[reader]`, goals, limits, scores |
| map --export csv | NAME.csv | a row a place: `x_m`, `y_m`, then every layer in W and dBm |

## netCDF

Read with `xarray.open_dataset`; complex arrays end with a dimension `part` (`re`, `im`).
""".replace("SCORES", "../evidence/scores.md")
VARIABLES_HEAD = "| variable | dimensions | unit | meaning |"
UNITS = {
    "_m_per_s": "m/s",
    "_rad_per_s": "rad/s",
    "_deg": "°",
    "_rad": "rad",
    "_dbm": "dBm",
    "_dbi": "dBi",
    "_db": "dB",
    "_hz": "Hz",
    "_ohm": "ohm",
    "_ns": "ns",
    "_us": "µs",
    "_m": "m",
    "_s": "s",
    "_w": "W",
}  # fmt: skip
SHARED_ENDS = ("_median", "_90", "_low", "_high", "_p90")
STUDY = """
name = "small"
[room]
box_m = [4.0, 4.0, 2.8]
material = "concrete"
[[tag]]
id = "1"
position_m = [2.5, 2.5, 2.6]
antenna = "conical_patch"
[reader]
antennas = 4
antenna_radius_m = 0.06
plate_height_m = 0.06
ground_plane_m = 0.16
ground_plane_shape = "round"
cells_per_wavelength = 5
[sweep]
plate_height_m = [0.0, 0.06]
[solver]
max_reflections = 1
[map]
spacing_m = 0.5
[mission]
start_m = [1.0, 1.0]
tags = ["1"]
navigator = "tracker"
runs = 1
"""
CALLS = {
    "map": "map STUDY --local-mean --local-mean-disc --spreads --out OUT/map.nc",
    "reader": "reader STUDY --step-deg 15 --out OUT",
    "sweep": "sweep STUDY --workers 1 --out OUT",
    "study": "study STUDY --quick --workers 1 --out OUT",
    "tolerance": "tolerance STUDY --samples 1 --workers 1 --out OUT",
    "dock": "dock --runs 1 --workers 1 --out OUT",
}
"""Runs that show what netCDF files hold."""


def columns(place: str) -> Sequence[str]:
    """Return the columns that a constant names.

    Parameters
    ----------
    place : ``module:NAME``.
    """
    module, name = place.split(":")
    return tuple(str(column) for column in getattr(importlib.import_module(module), name))


def unit_and_stem(column: str) -> tuple[str, str]:
    """Return the unit of a column, and its name without unit and shared ending.

    Parameters
    ----------
    column : Its name.
    """
    stem, unit = column, ""
    for _ in range(2):
        for end in SHARED_ENDS:
            stem = stem.removesuffix(end)
        for end, name in UNITS.items():
            if not unit and stem.endswith(end):
                stem, unit = stem.removesuffix(end), name
    return unit, stem


def meaning(column: str, meanings: Mapping[str, str]) -> str | None:
    """Return what a column means; None: nobody has said it.

    Parameters
    ----------
    column, meanings : Its name; what is known, by stem.
    """
    return next((meanings[n] for n in (column, unit_and_stem(column)[1]) if n in meanings), None)


def known_meanings() -> Mapping[str, str]:
    """Return what the columns mean, by stem; a design's columns are keys of a study file."""
    found: dict[str, str] = tomllib.loads((DOCS / "columns.toml").read_text("utf-8"))["meaning"]
    return found


def page() -> str:
    """Return the page."""
    lines, meanings = [HEAD, "## Tables (CSV)", ""], known_meanings()
    for verb, file, place in CSV_FILES:
        lines += [
            f"### `{file}` of octant {verb}",
            "",
            "| column | unit | meaning |",
            "|---|---|---|",
        ]
        for column in columns(place):
            unit = unit_and_stem(column)[0]
            lines.append(f"| `{column}` | {unit} | {meaning(column, meanings) or ''} |")
        lines.append("")
    lines.append(BY_STUDY)
    for verb, files in json.loads(VARIABLES.read_text("utf-8")).items():
        for file, variables in files.items():
            lines += [f"### `{file}` of octant {verb}", "", VARIABLES_HEAD, "|---|---|---|---|"]
            lines += [
                f"| `{name}` | {', '.join(dims)} | {units} | {text} |"
                for name, (dims, units, text) in variables.items()
            ]
            lines.append("")
    return "\n".join(lines)


def held(folder: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the netCDF files at the top of a folder, and their variables.

    Parameters
    ----------
    folder : Of a run.
    """
    import xarray as xr

    for path in sorted(folder.glob("*.nc")):
        with xr.open_dataset(path, engine="h5netcdf") as data:
            yield (
                path.name,
                {
                    str(name): [
                        list(map(str, v.dims)),
                        v.attrs.get("units", ""),
                        v.attrs.get("long_name", ""),
                    ]
                    for name, v in data.variables.items()
                },
            )


def run_all(folder: Path) -> dict[str, dict[str, Any]]:
    """Return what the netCDF files of all small runs hold, by verb and file.

    Parameters
    ----------
    folder : Where they are run.
    """
    from octant.reader_design import cli

    folder.mkdir(parents=True, exist_ok=True)
    study = folder / "small.toml"
    study.write_text(STUDY, "utf-8")
    found = {}
    for verb, call in CALLS.items():
        out = folder / verb
        out.mkdir(exist_ok=True)
        words = call.replace("STUDY", str(study)).replace("OUT", str(out)).split()
        if cli.run([*words, "--quiet"]) not in {0, 3}:
            raise click.ClickException(call)
        found[verb] = dict(held(out))
    return {verb: files for verb, files in found.items() if files}


if __name__ == "__main__":
    VARIABLES.write_text(
        json.dumps(run_all(Path(sys.argv[1])), indent=1, ensure_ascii=False) + "\n", "utf-8"
    )
