"""``octant simulate-log``: the log that a robot would bring home from a drive."""

from pathlib import Path

import click

from octant.geometries.errors import ConfigError
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import (
    approve,
    common_options,
    number,
    seed_option,
    study_argument,
    written_line,
)
from octant.reader_design.study_file.quantities import Count, Deviation, Distance, Period
from octant.reader_design.terminal.completion import files

_STEP_M, _PERIOD_S = 0.1, 1.0
_MOST_POSES = 1_000_000


@click.command(name="simulate-log")
@study_argument
@click.option(
    "--out",
    type=click.Path(path_type=Path),
    default=Path("log.csv"),
    show_default=True,
    shell_complete=files(".csv"),
    help="The log.",
)
@click.option(
    "--way",
    default="tags",
    show_default=True,
    metavar="tags|floor|FILE",
    shell_complete=files(".csv"),
    help="Drive under one tag after another, on lanes over the floor, or to the poses of a CSV "
    "with x_m,y_m,heading_deg.",
)
@click.option(
    "--step-m",
    "step_m",
    type=number(Distance),
    metavar="M",
    help="Way between readings [m]; default: that of [mission], or 0.1.",
)
@click.option(
    "--spacing-m",
    "spacing_m",
    type=number(Distance),
    default=0.5,
    show_default=True,
    metavar="M",
    help="Distance of the lanes over the floor [m].",
)
@click.option(
    "--period-s",
    "period_s",
    type=number(Period),
    metavar="S",
    help="Time from one pose to the next [s]; default: that of [mission], or 1.",
)
@click.option("--runs", type=number(Count), default=1, help="How often the way is driven.")
@click.option(
    "--noise-db",
    type=number(Deviation),
    metavar="DB",
    help="Noise of each reading [dB]; default: that of [mission] or [dock], or none.",
)
@click.option(
    "--antenna",
    type=click.Choice(["reader", "dipole", "monopole", "isotropic_theta"]),
    default="reader",
    show_default=True,
    help="What the robot carries: the study's reader, or one upright antenna.",
)
@click.option("--hop", is_flag=True, help="Each reading at one of the channels, not their mean.")
@click.option("--local-mean", is_flag=True, help="Power sums over the paths: no fast fading.")
@seed_option
@common_options
def simulate_log(
    *,
    study: Path | None,
    out: Path,
    way: str,
    step_m: float | None,
    spacing_m: float,
    period_s: float | None,
    runs: int,
    noise_db: float | None,
    antenna: str,
    hop: bool,
    local_mean: bool,
    seed: int | None,
    force: bool,
    quiet: bool,
) -> None:
    """Write the log of a robot that drives through the room of STUDY and reads all its tags.

    It is the CSV that compare, calibrate and replay read: time, true pose, odometry, tag, antenna,
    level in dBm (-inf: not heard) and frequency, with the noise, sensitivity and losses of the
    table [sensor] and the wheels of [robot]. With it the whole chain runs on known truth.
    """
    from octant.geometries.files import refuse_overwrite
    from octant.navigation.logs.log_csv import write_log
    from octant.reader_design.experiments.measured.simulate import (
        Readings,
        simulated_log,
        with_antenna,
    )
    from octant.reader_design.experiments.measured.simulate_ways import (
        poses_of_file,
        way_over_floor,
        way_through_tags,
    )
    from octant.reader_design.face.rss_readings import study_noise_db
    from octant.reader_design.setting.cost import field_cost, reader_cost
    from octant.reader_design.setting.measured import with_log
    from octant.reader_design.setting.setting import build_setting
    from octant.reader_design.setting.solving import solved
    from octant.reader_design.study_file.loading import load_study

    loaded, progress = with_log(load_study(study)), Progress(quiet=quiet)
    refuse_overwrite(out, force=force)
    setting = build_setting(loaded)
    mission = loaded.mission
    step_m = step_m or (_STEP_M if mission is None else mission.cruise_step_m)
    period_s = period_s or (_PERIOD_S if mission is None else mission.sample_time_s)
    if way == "tags":
        poses = way_through_tags(setting, step_m=step_m)
    elif way == "floor":
        poses = way_over_floor(setting, spacing_m=spacing_m, step_m=step_m)
    else:
        poses = poses_of_file(Path(way))
    if runs * len(poses) > _MOST_POSES:
        msg = (
            f"{runs} runs of {len(poses)} poses are {runs * len(poses)} poses, but a log has at "
            f"most {_MOST_POSES}; ask for fewer --runs, or a longer --step-m."
        )
        raise ConfigError(msg)
    for note in setting.notes:
        progress.say(note)
    cost = field_cost(loaded, runs * len(poses), tags=len(setting.tags), causes=("--runs",))
    approve(reader_cost(loaded).and_then(cost) if antenna == "reader" else cost, progress)
    setting = solved(setting, progress) if antenna == "reader" else with_antenna(setting, antenna)
    how = Readings(
        period_s=period_s,
        noise_db=study_noise_db(loaded) if noise_db is None else noise_db,
        hop=hop,
        local_mean=local_mean,
        runs=runs,
        seed=loaded.seed if seed is None else seed,
    )
    log = simulated_log(setting, poses, how, progress=progress)
    write_log(out, log)
    heard = int(log.heard.sum())
    click.echo(
        f"{len(log)} readings of {len(log.ids)} tags at {runs * len(poses)} poses, of which "
        f"{len(log) - heard} were not heard"
    )
    click.echo(written_line([out]))
