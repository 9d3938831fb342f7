"""Which physics pays on a measured log: orders, transmission, diffraction, beside laws of distance.

Run as ``python benchmarks/bench_measured.py STUDY.toml [--orders 0,1,2,3,4] [--json FILE]``, with a
study whose table ``[log]`` names a log. Of each solver setting it prints the standard deviation of
local means about the prediction with a free level for each anchor, and the error that is held out
one anchor at a time when ``--fit`` is fitted besides (the anchor's own numbers from its own
readings, shared ones from the others).
"""

import argparse
import json
import time
import warnings
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.measured.agreement import pooled_sd_db
from octant.reader_design.experiments.measured.calibrate import Problem, Wanted, calibrated
from octant.reader_design.experiments.measured.predict import Values
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.measured import measured_log, with_log
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import load_study, vary

WITHIN = "readings within a cell"


def row(problem: Problem, folder: Path) -> dict[str, object]:
    """Return one line of the table [dB], [s].

    Parameters
    ----------
    problem, folder : What is fitted; where its fits are kept.
    """
    begin = time.process_time()
    out: dict[str, object] = {}
    o = problem.observations
    try:
        found = calibrated(problem, folder, Progress())
    except ConfigError as exc:
        return {"said": str(exc), "cpu_s": time.process_time() - begin}
    log = problem.rows.log
    gain = problem.predictor.gains(Values())[log.sources, problem.rows.group, 0]
    dark = o.means((gain == 0.0).astype(np.float64)) > 0.0  # no path arrives
    reached = np.where(dark, np.nan, found.before_db)
    out["dark_share"] = float(np.mean(dark))
    out["level_only_db"] = pooled_sd_db(reached, o.sources)
    out["held_out_db"] = found.held_out_sd_db
    out["values"] = {
        p.name: v.value for p, v in zip(problem.parameters, found.values, strict=True) if not p.own
    }
    out["laws"] = {law.name: law.sd_db for law in found.baselines} | {WITHIN: o.scatter_db}
    out["cpu_s"] = time.process_time() - begin
    return out


def main() -> None:
    """Print the table, and keep it where asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("study", type=Path)
    parser.add_argument("--orders", default="0,1,2,3,4")
    parser.add_argument("--diffraction", default="off,on")
    parser.add_argument("--transmission", default="on,off")
    parser.add_argument("--fit", default="level,diffuse,sigma:walls")
    parser.add_argument("--antenna", default="dipole")
    parser.add_argument("--place-m", type=float, default=0.25)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    study = with_log(load_study(given.study))
    log = measured_log(study, build_setting(study).scene).log
    wanted = Wanted(
        names=tuple(given.fit.split(",")),
        antenna=given.antenna,
        folds="anchors",
        place_m=given.place_m,
    )
    rows: list[dict[str, object]] = []
    print("order transmission diffraction  no path  level only  held out   cpu")
    for through, edges, order in product(
        given.transmission.split(","),
        given.diffraction.split(","),
        map(int, given.orders.split(",")),
    ):
        varied = vary(
            study,
            {
                "solver.max_reflections": order,
                "solver.transmission": through == "on",
                "solver.diffraction": edges == "on",
            },
        )
        with TemporaryDirectory() as folder:
            one = row(Problem(study=varied, log=log, wanted=wanted), Path(folder))
        rows.append({"order": order, "transmission": through, "diffraction": edges, **one})
        print(
            f"{order:5d} {through:>12} {edges:>11} "
            f"{100 * float(str(one.get('dark_share', 'nan'))):7.0f} % "
            f"{float(str(one.get('level_only_db', 'nan'))):8.2f} dB "
            f"{float(str(one.get('held_out_db', 'nan'))):6.2f} dB {one['cpu_s']:5.0f} s "
            f"{one.get('values', '')} {one.get('said', '')}",
            flush=True,
        )
        if given.json is not None:
            given.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    for name, value in (rows[0].get("laws") or {}).items():  # type: ignore[attr-defined]
        print(f"{name}: {value:.2f} dB")


if __name__ == "__main__":
    main()
