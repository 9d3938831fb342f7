"""Signals at random times: whether the same command then finishes with the same bits.

``python tools/interruptions.py [VERB ...] [--trials N] [--seed S]`` runs each verb twice
undisturbed, in new folders with a new cache, and then N times with one to three signals, each at a
random moment of a run: Ctrl-C to all its processes, SIGINT, SIGTERM or SIGKILL to the first one.
After each it types the same command again, the last time undisturbed. With ``--together``, the same
command is instead typed again while the first still runs. A finding is a traceback, an
exit code other than 0, 130 or the signal's, a process that outlives its run, or a result that is
not the undisturbed run's to the bit: columns of CSV, variables and attributes of netCDF files,
all other files whole. What differs between the two undisturbed runs, as the time that a computation
took, is named and left out. Exit code: 1 if there are findings.
"""

import argparse
import csv
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import xarray as xr

STUDY = """
[room]
box_m = [5.0, 4.0, 3.0]
material = "concrete"

[[room.object]]
kind = "cabinet"
position_m = [2.0, 3.2, 0.0]
size_m = [1.0, 0.5, 1.8]
material = "metal"

[[tag]]
id = "A"
position_m = [1.2, 1.0, 2.4]
antenna = "dipole"

[[tag]]
id = "B"
position_m = [3.6, 2.4, 2.4]
antenna = "dipole"

[reader]
antenna_radius_m = 0.05
plate_height_m = 0.05

[solver]
max_reflections = 2

[map]
spacing_m = 0.04

[mission]
navigator = "thesis"
start_m = [0.6, 0.6]
tags = ["A", "B"]
runs = 12

[tolerance]
samples = 3

[optimise]
survey = 2
evaluations = 4
parameters = { antenna_radius_m = [0.03, 0.05] }
[[optimise.goal]]
score = "right_share"
value = 1.0

[sweep]
antenna_radius_m = [0.03, 0.04]
plate_height_m = [0.02, 0.05]
"""
LOG = ("simulate-log", "measured.toml", "--way", "floor", "--spacing-m", "0.5", "--noise-db", "1")
"""How the log is made that other verbs read."""
MEASURED = ("room", "tag", "reader", "solver", "mission")
"""Tables of the study that verbs of a log read; others are of other verbs."""
VERBS = {
    "sweep": ("sweep", "study.toml", "--out", "out", "--workers", "2"),
    "map": ("map", "study.toml", "--out", "out/map.nc"),
    "navigate": ("navigate", "study.toml", "--out", "out", "--workers", "2"),
    "tolerance": ("tolerance", "study.toml", "--out", "out", "--workers", "2"),
    "optimise": ("optimise", "study.toml", "--out", "out", "--workers", "2"),
    "reader": ("reader", "study.toml", "--out", "out", "--convergence"),
    "study": ("study", "study.toml", "--quick", "--out", "out", "--workers", "2"),
    "track": ("track", "--out", "out", "--workers", "2"),
    "dock": ("dock", "--runs", "6", "--out", "out", "--workers", "2"),
    "simulate-log": (*LOG, "--out", "out/log.csv", "--force"),
    "compare": ("compare", "measured.toml", "--log", "log.csv", "--out", "out"),
    "calibrate": (
        *("calibrate", "measured.toml", "--log", "log.csv", "--out", "out"),
        *("--fit", "level,diffuse,eps_r:concrete", "--folds", "3"),
    ),
    "replay": (
        *("replay", "measured.toml", "--log", "log.csv", "--out", "out", "--workers", "2"),
        *("--estimator", "tracker"),
    ),
}
"""What is typed behind ``octant`` in a folder that holds study.toml, measured.toml and log.csv."""

MAIN = "from octant.reader_design.cli import main; main()"
KINDS = ("Ctrl-C", "SIGINT", "SIGTERM", "SIGKILL")
LONGEST_S = 1200.0
GRACE_S = 20.0


def started(verb: str, folder: Path, stderr: str) -> subprocess.Popen[bytes]:
    """Return the verb's process, the first of a group of its own."""
    environment = os.environ | {"OCTANT_CACHE_DIR": str(folder / "cache")}
    with (folder / stderr).open("wb") as error, (folder / "stdout").open("wb") as output:
        return subprocess.Popen(
            [sys.executable, "-c", MAIN, *VERBS[verb]],
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=error,
            start_new_session=True,
        )


def disturb(process: subprocess.Popen[bytes], kind: str) -> None:
    """Send a signal to a process, or to all of its group as a terminal does."""
    if kind == "Ctrl-C":
        os.killpg(process.pid, signal.SIGINT)
    else:
        process.send_signal(signal.Signals[kind])


def left_over(group: int) -> bool:
    """Return whether a process of a group is still there after a while."""
    end = time.monotonic() + GRACE_S
    while time.monotonic() < end:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return False
        time.sleep(0.1)
    os.killpg(group, signal.SIGKILL)
    return True


def run(
    verb: str, folder: Path, kind: str = "", after_s: float = 0.0, stderr: str = "stderr"
) -> tuple[int, list[str]]:
    """Return the exit code of a run, disturbed after a while if it still runs, and its faults."""
    process = started(verb, folder, stderr)
    disturbed = False
    try:
        process.wait(after_s if kind else LONGEST_S)
    except subprocess.TimeoutExpired:
        disturb(process, kind or "SIGKILL")
        disturbed = True
        process.wait(GRACE_S)
    code = process.returncode
    faults = []
    if disturbed and not kind:
        faults.append(f"not finished after {LONGEST_S:.0f} s")
    error = (folder / stderr).read_text(errors="replace")
    ended = (-signal.SIGINT, -signal.SIGTERM, -signal.SIGKILL)  # a shell says 128 more: 130, ...
    good = (0, 130, *ended) if disturbed else (0,)
    if code not in good:
        faults.append(f"exit code {code} after {kind or 'nothing'}")
    if "Traceback" in error:
        faults.append(f"traceback after {kind or 'nothing'}: {error[-400:]!r}")
    if left_over(process.pid):
        faults.append(f"a process outlives its run by {GRACE_S:.0f} s after {kind or 'nothing'}")
    return code, faults


def run_together(verb: str, folder: Path, after_s: float) -> tuple[str, list[str]]:
    """Return what two equal commands did, one begun a while after the other, and their faults."""
    with ThreadPoolExecutor() as pool:
        first = pool.submit(run, verb, folder, stderr="first")
        time.sleep(after_s)
        second = pool.submit(run, verb, folder, stderr="second")
        (code, faults), (other, more) = first.result(), second.result()
    return f"two, {after_s:.1f} s apart: {code} and {other}", faults + more


def parts_of(path: Path) -> Iterator[tuple[str, object]]:
    """Yield name and content of the columns of a CSV file, the variables of a netCDF file, ..."""
    if path.suffix == ".csv":
        rows = list(csv.reader(path.read_text().splitlines()))
        for k, column in enumerate(rows[0] if rows else ()):
            yield column, [row[k] for row in rows[1:]]
    elif path.suffix == ".nc":
        with xr.open_dataset(path, engine="h5netcdf", decode_timedelta=False) as data:
            for name, variable in data.variables.items():
                yield str(name), (variable.dims, variable.values.tobytes())
            yield from ((f"attribute {k}", str(v)) for k, v in data.attrs.items())
    else:
        yield "", path.read_bytes()


def results(folder: Path) -> dict[str, object]:
    """Return the results in the folder ``out``, part by part."""
    out = folder / "out"
    return {
        f"{path.relative_to(out)} {name}".strip(): content
        for path in sorted(out.rglob("*"))
        if path.is_file() and not path.name.startswith(".")  # what a killed write left
        for name, content in parts_of(path)
    }


def fill(folder: Path, log: bytes) -> None:
    """Write what a verb reads into a new folder."""
    (folder / "study.toml").write_text(STUDY)
    tables = re.split(r"\n(?=\[)", STUDY)
    own = [table for table in tables if table.strip("[ \n").startswith(MEASURED)]
    (folder / "measured.toml").write_text("\n".join(own))
    if log:
        (folder / "log.csv").write_bytes(log)


def log_of(verb: str, folder: Path) -> bytes:
    """Return the log that a verb reads, made in a new folder; nothing where it reads none."""
    if "log.csv" not in VERBS[verb]:
        return b""
    folder.mkdir()
    fill(folder, b"")
    made = [sys.executable, "-c", MAIN, *LOG, "--quiet"]
    subprocess.run(made, cwd=folder, check=True)
    return (folder / "log.csv").read_bytes()


def tried(verb: str, trials: int, draws: random.Random, *, together: bool) -> list[str]:
    """Return what is wrong with a verb that is disturbed, and print what was done."""
    findings = []
    with tempfile.TemporaryDirectory(prefix="interruptions-") as name:
        log = log_of(verb, Path(name) / "log")
        whole = []
        lasts_s = 0.0
        for k in range(2):
            folder = Path(name) / f"whole{k}"
            folder.mkdir()
            fill(folder, log)
            start = time.monotonic()
            code, faults = run(verb, folder)
            lasts_s = time.monotonic() - start
            if faults:
                error = (folder / "stderr").read_text(errors="replace")[-400:]
                return [f"{verb}: undisturbed run: {faults} {error!r}"]
            whole.append(results(folder))
        same = {n for n in whole[0] if whole[0][n] == whole[1].get(n)}
        print(f"{verb}: {lasts_s:.1f} s, {len(same)} parts compared", end="; ")
        left_out = sorted({re.sub("[0-9a-f]{32}", "*", n) for n in set(whole[0]) - same})
        print(f"left out: {left_out}")
        for trial in range(trials):
            folder = Path(name) / f"trial{trial}"
            folder.mkdir()
            fill(folder, log)
            done = []
            if together:
                what, faults = run_together(verb, folder, draws.uniform(0.0, lasts_s))
                done.append(what)
                findings += [f"{verb} {done}: {fault}" for fault in faults]
            else:
                for _ in range(draws.randint(1, 3)):
                    kind, after_s = draws.choice(KINDS), draws.uniform(0.2, lasts_s)
                    code, faults = run(verb, folder, kind, after_s)
                    done.append(f"{kind} at {after_s:.1f} s: {code}")
                    findings += [f"{verb} {done}: {fault}" for fault in faults]
            code, faults = run(verb, folder)
            findings += [f"{verb} {done}, then undisturbed: {fault}" for fault in faults]
            got = results(folder)
            other = sorted(n for n in same if got.get(n) != whole[0][n])
            more = sorted(set(got) - set(whole[0]))
            if other or more:
                findings.append(f"{verb} {done}: other bits in {other}, more parts {more}")
            print(f"  trial {trial}: {'; '.join(done)}; then {code}, {len(other)} parts differ")
            sys.stdout.flush()
    return findings


def main() -> int:
    """Try the verbs that are named, or all; return the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("verbs", nargs="*", metavar="VERB", help=f"of {', '.join(VERBS)}")
    parser.add_argument("--trials", type=int, default=5, help="disturbed runs of each verb")
    parser.add_argument("--seed", type=int, default=1, help="of the signals and their moments")
    parser.add_argument("--together", action="store_true", help="two commands at once, no signals")
    options = parser.parse_args()
    # A shell starts what runs in the background with this signal ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    findings = []
    for verb in options.verbs or VERBS:
        draws = random.Random(f"{verb} {options.seed}")  # noqa: S311
        findings += tried(verb, options.trials, draws, together=options.together)
    print(*findings, f"{len(findings)} findings", sep="\n")
    return int(bool(findings))


if __name__ == "__main__":
    sys.exit(main())
