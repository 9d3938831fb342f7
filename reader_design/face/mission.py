"""A robot's drive through tags: what is asked for, and the runs of it."""

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.navigation.missions.files import write_missions_csv, write_trajectory_csv
from octant.navigation.missions.metrics import MissionMetrics, measure
from octant.navigation.missions.pilot import Pilot, SimulatedReader
from octant.navigation.missions.records import MissionResult
from octant.navigation.missions.summary import summarise, summary_sentences
from octant.navigation.navigators.own import place_of
from octant.reader_design.drives.files import write_mcap, write_tum
from octant.reader_design.experiments.missions.advice import Advice, advise
from octant.reader_design.experiments.missions.animation import (
    drive_frames,
    run_scenery,
    write_gif,
)
from octant.reader_design.experiments.missions.compute import drive_missions, mission_runs
from octant.reader_design.experiments.missions.drive_figures import drive_of, trajectory_figure
from octant.reader_design.experiments.missions.logs import mission_log
from octant.reader_design.face.reader import Reader
from octant.reader_design.face.room import Room, link_study
from octant.reader_design.face.shown import figure_html, image_html, progress_of, text_html
from octant.reader_design.face.tables import Tag
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.setting import Setting, build_setting, mission_table
from octant.reader_design.setting.solving import solved
from octant.reader_design.showing.netcdf import variable
from octant.reader_design.showing.plan import plan_of
from octant.reader_design.showing.scene_glb import (
    reader_bodies,
    tag_bodies,
    way_body,
    write_scene,
)
from octant.reader_design.study_file.schema import Study

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure


class Mission:
    """A drive through tags, with a reader on a robot in a room.

    Parameters
    ----------
    room, tags : The room and the tags that hang in it.
    reader : The reader; by default that of the thesis.
    start : (2,) or (3,) — Where the robot starts: x, y [m] and heading [deg], by default 90.
    frequency_hz, channels_hz : Carrier and hopping frequencies [Hz].
    robot, sensor, solver, rfid : Keys of the tables of these names of a study file.
    name : In titles.
    navigator : ``thesis``, ``tracker``, or a class of your own (see `Navigator`), or its name as in
        a study file; by default as there.
    **keys : Of the table ``[mission]``: ``controller``, ``noise_db`` and so on.
    order : Names of the tags to visit, in this order; by default all, as given.

    Examples
    --------
    >>> import octant
    >>> tag = octant.Tag("1", (1.5, 1.0, 2.0))
    >>> reader = octant.Reader(response="isolated")
    >>> mission = octant.Mission(octant.Room.free_space(), [tag], reader, start=(0.0, 0.0, 90.0))
    >>> mission
    <Mission: 1 from (0, 0) m at 90 deg, navigator tracker>
    >>> mission.run(2, seed=1, progress=False).success.dims
    ('run',)
    """

    __slots__ = ("own", "study")
    study: Study
    own: type | None

    def __init__(
        self,
        room: Room,
        tags: Sequence[Tag],
        reader: Reader | None = None,
        *,
        start: Sequence[float],
        order: Sequence[str] | None = None,
        frequency_hz: float = 2.4e9,
        channels_hz: Sequence[float] = (),
        robot: Mapping[str, Any] | None = None,
        sensor: Mapping[str, Any] | None = None,
        solver: Mapping[str, Any] | None = None,
        rfid: Mapping[str, Any] | None = None,
        navigator: str | type | None = None,
        name: str = "mission",
        **keys: Any,  # noqa: ANN401  keys of the table [mission]
    ) -> None:
        place = [float(c) for c in np.asarray(start, dtype=np.float64).ravel()]
        if len(place) not in {2, 3}:
            msg = f"start is {start!r}, but x, y [m] and the heading [deg] are needed."
            raise ConfigError(msg)
        table = {
            "start_m": place[:2],
            "heading_deg": place[2] if len(place) == 3 else 90.0,
            "tags": [tag.id for tag in tags] if order is None else list(order),
            **keys,
        }
        self.own = navigator if isinstance(navigator, type) else None
        if navigator is not None:
            table["navigator"] = navigator if self.own is None else place_of(self.own).name
        self.study = link_study(
            room,
            tags,
            reader,
            {
                "name": name,
                "mission": table,
                "robot": robot,
                "sensor": sensor,
                "solver": solver,
                "rfid": rfid,
            },
            frequency_hz=frequency_hz,
            channels_hz=channels_hz,
        )

    @classmethod
    def of(cls, study: Study) -> "Mission":
        """Return the mission of a study.

        Parameters
        ----------
        study : With a table ``[mission]``.
        """
        mission_table(study)
        made = cls.__new__(cls)
        made.study, made.own = study, None
        return made

    def run(
        self,
        runs: int | None = None,
        *,
        seed: int | None = None,
        noise_db: float | None = None,
        progress: bool | Progress = True,
    ) -> "MissionRuns":
        """Return the runs of the mission; refuse one that cannot be driven with this reader.

        Parameters
        ----------
        runs, seed, noise_db : Number, seed, and noise of each reading [dB]; by default the study's.
        progress : False silences it.
        """
        study = self.study if seed is None else msgspec.structs.replace(self.study, seed=seed)
        table = mission_table(study)
        shown = progress_of(progress)
        setting = build_setting(study)
        for note in setting.notes:
            shown.say(note)
        solved(setting, shown)
        number = table.runs if runs is None else runs
        with shown.count(number, label="missions") as done:
            results = drive_missions(
                setting, runs=number, noise_db=noise_db, own=self.own, progress=done
            )
        if table.placement_m > 0.0:  # run 0 is shown among the objects as they were placed
            setting = mission_runs(setting, runs=number, own=self.own)[0].setting
        return MissionRuns(setting=setting, results=tuple(results))

    def pilot(
        self, *, seed: int | None = None, progress: bool | Progress = True
    ) -> tuple[Pilot, SimulatedReader]:
        """Return the mission's navigator, to be driven from outside, and its reader in the room.

        A robot's loop (ROS, another simulator) feeds the `Pilot` with readings and odometry and
        drives as it says; the reader gives readings where there is no real one.

        Parameters
        ----------
        seed : Of navigator and noise; by default the study's. They are those of ``run``'s run 0.
        progress : False silences it.

        Examples
        --------
        >>> import octant
        >>> mission = octant.Mission(
        ...     octant.Room.free_space(),
        ...     [octant.Tag("1", (1.5, 1.0, 2.0))],
        ...     octant.Reader(response="isolated"),
        ...     start=(0.0, 0.0, 90.0),
        ...     navigator="thesis",
        ... )
        >>> pilot, reader = mission.pilot(seed=1, progress=False)
        >>> step = pilot.step(reader.read(pilot.start, pilot.tag_id))
        >>> (pilot.tag_id, step.mode, step.done)
        ('1', 'rotation', False)
        """
        study = self.study if seed is None else msgspec.structs.replace(self.study, seed=seed)
        shown = progress_of(progress)
        setting = build_setting(study)
        for note in setting.notes:
            shown.say(note)
        solved(setting, shown)
        first = mission_runs(setting, runs=1, own=self.own)[0]
        (child,) = np.random.SeedSequence(first.seed).spawn(1)
        return Pilot(first.job, child), SimulatedReader(first.job, child)

    def __repr__(self) -> str:
        table = mission_table(self.study)
        x, y = table.start_m
        return (
            f"<Mission: {' -> '.join(table.tags)} from ({x:g}, {y:g}) m at "
            f"{table.heading_deg:g} deg, navigator {table.navigator}>"
        )

    def _repr_html_(self) -> str:
        return text_html(repr(self))


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MissionRuns:
    """The runs of a mission.

    Parameters
    ----------
    setting, results : The reader in its room, with random placements that of run 0; every run.
    """

    setting: Setting
    results: tuple[MissionResult, ...]

    def __len__(self) -> int:
        return len(self.results)

    @property
    def metrics(self) -> tuple[MissionMetrics, ...]:
        """Success, times, lengths and errors of every run."""
        return tuple(measure(result) for result in self.results)

    @property
    def data(self) -> "xr.Dataset":
        """Success, time [s], length [m], errors and reason of every run, with units."""
        import xarray as xr

        metrics = self.metrics
        columns = (
            ("success", "1", "whether every tag was reached"),
            ("captured", "1", "whether the field held the robot at a wrong place"),
            ("collided", "1", "whether the robot ran into something"),
            ("time_s", "s", "duration"),
            ("path_m", "m", "length of the path driven"),
            ("rmse_m", "m", "rms distance to the straight segments"),
            ("p90_position_m", "m", "position error of 90 % of the time"),
            ("p90_heading_rad", "rad", "heading error of 90 % of the time"),
        )
        variables = {
            name: variable(
                ["run"], [getattr(m, name) for m in metrics], units=units, long_name=text
            )
            for name, units, text in columns
        }
        variables["arrival_error_m"] = variable(
            ["run", "target_tag"],
            np.array([m.arrival_errors_m for m in metrics]),
            units="m",
            long_name="distance from the tag's point on arrival",
        )
        variables["ended_because"] = variable(
            ["run"], [m.reason for m in metrics], units="1", long_name="why the run ended"
        )
        tags = list(self.setting.mission.tags)
        names = {
            "run": variable(["run"], np.arange(len(self)), units="1", long_name="run"),
            "target_tag": variable(
                ["target_tag"], tags, units="1", long_name="tag, in order of the visit"
            ),
        }
        return xr.Dataset(variables, coords=names)

    @property
    def success(self) -> "xr.DataArray":
        """Whether each run reached every tag."""
        return self.data["success"]

    def trajectory(self, run: int = 0) -> "xr.Dataset":
        """Return the way of one run: time [s], pose [m], [rad], and RSS [W] of every antenna.

        Parameters
        ----------
        run : Number of the run.
        """
        import xarray as xr

        result = self._result(run)

        def row(values: npt.ArrayLike, units: str, long_name: str) -> "xr.Variable":
            return variable(["step"], values, units=units, long_name=long_name)

        ids = np.array(result.mission.tag_ids)
        return xr.Dataset(
            {
                "x": row(result.poses[:, 0], "m", "x of the robot"),
                "y": row(result.poses[:, 1], "m", "y of the robot"),
                "heading": row(result.poses[:, 2], "rad", "heading of the robot"),
                "mode": row(list(result.modes), "1", "what the navigator does"),
                "target": row(ids[result.targets], "1", "tag that is read"),
                "rss_w": variable(
                    ["step", "antenna"], result.rss_w, units="W", long_name="reading"
                ),
            },
            coords={
                "t": row(result.time_s, "s", "time"),
                "antenna": variable(
                    ["antenna"],
                    np.arange(1, result.rss_w.shape[1] + 1),
                    units="1",
                    long_name="antenna of the reader",
                ),
            },
            attrs={"outcome": result.outcome, "reason": result.reason},
        )

    def animate(self, run: int = 0) -> "Animation":
        """Return one run as an animated picture: robot, antennas, RSS and the field under them.

        Parameters
        ----------
        run : Number of the run.
        """
        result = self._result(run)
        scenery = run_scenery(self.setting, result)
        frames = drive_frames(drive_of(result), scenery, title=self.setting.study.name)
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "run.gif"
            count = write_gif(file, frames)
            return Animation(content=file.read_bytes(), frames=count)

    def plot(self, run: int = 0) -> "Figure":
        """Return the way of one run in a plan of the room.

        Parameters
        ----------
        run : Number of the run.
        """
        result = self._result(run)
        mission = result.mission
        points = dict(zip(mission.tag_ids, mission.tag_points_m, strict=True))
        plan = plan_of(self.setting.scene, self.setting.reader_z_m)
        drawn = [(self.setting.name, drive_of(result), plan)]
        return trajectory_figure(drawn, points, title=f"{self.setting.study.name}, run {run}")

    def to_dataframe(self) -> "pd.DataFrame":
        """Return a table with a row a run."""
        frame: pd.DataFrame = self.data.drop_dims("target_tag").to_dataframe()
        return frame

    def to_csv(self, folder: str | Path) -> tuple[Path, Path]:
        """Return the files ``missions.csv`` and ``trajectory.csv`` (run 0) that are written.

        Parameters
        ----------
        folder : Where they are written; replaced where they exist.
        """
        place = Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        write_missions_csv(place / "missions.csv", self.results)
        write_trajectory_csv(place / "trajectory.csv", self.results[0])
        return place / "missions.csv", place / "trajectory.csv"

    def to_mcap(self, path: str | Path, run: int = 0) -> None:
        """Write one run with ROS 2 messages, for Foxglove and RViz; needs ``octant[ros]``.

        Parameters
        ----------
        path, run : The file, replaced where it exists; number of the run.
        """
        result = self._result(run)
        write_mcap(mission_log(self.setting, result, run=run), Path(path))

    def to_glb(self, path: str | Path, run: int = 0) -> None:
        """Write the room with tags, reader at the run's end and way as named nodes of a GLB file.

        Parameters
        ----------
        path, run : The file, replaced where it exists; number of the run.
        """
        result, setting = self._result(run), self.setting
        extent_m, floor_m = max(setting.scene.extent_m, 1.0), setting.scene.floor_height_m
        x, y, heading = result.poses[-1].tolist()
        shown = [
            *tag_bodies({tag.id: tag.position_m for tag in setting.tags}, extent_m),
            *reader_bodies(
                setting.reader,
                (x, y, heading),
                setting.reader_z_m,
                frequency_hz=setting.study.radio.frequency_hz,
            ),
            way_body(result.poses[:, :2], floor_m, extent_m, name=f"trajectory run {run}"),
        ]
        write_scene(setting.scene, Path(path), paths=None, ends_m={}, shown=shown)

    def to_tum(self, path: str | Path, run: int = 0) -> None:
        """Write the true way of one run as a TUM trajectory: t x y z qx qy qz qw [s], [m].

        Parameters
        ----------
        path, run : The file, replaced where it exists; number of the run.
        """
        result = self._result(run)
        write_tum(Path(path), result.time_s, result.poses)

    @property
    def advice(self) -> Advice | None:
        """What happened where runs failed, and what to try; None: nearly all reached every tag."""
        return advise(self.setting, self.results)

    def lines(self) -> Iterator[str]:
        """Yield what a person wants to read about the runs, with 95 % intervals, and advice."""
        yield from summary_sentences(summarise(self.metrics))
        if (advice := self.advice) is not None:
            yield from advice.text().splitlines()

    def _result(self, run: int) -> MissionResult:
        if not 0 <= run < len(self):
            msg = f"run {run} is asked for, but the runs are numbered 0 to {len(self) - 1}."
            raise ConfigError(msg)
        return self.results[run]

    def __repr__(self) -> str:
        reached = sum(m.success for m in self.metrics)
        tags = " -> ".join(self.setting.mission.tags)
        return f"<MissionRuns: {reached} of {len(self)} runs reached every tag ({tags})>"

    def _repr_html_(self) -> str:
        text = "\n".join([repr(self), *self.lines()])
        return text_html(text) + figure_html(self.plot())


@dataclass(frozen=True, slots=True, kw_only=True)
class Animation:
    """A moving picture.

    Parameters
    ----------
    content, frames : A GIF file and the number of its frames.
    """

    content: bytes
    frames: int

    def save(self, path: str | Path) -> None:
        """Write the GIF file.

        Parameters
        ----------
        path : The file; replaced where it exists.
        """
        Path(path).write_bytes(self.content)

    def __repr__(self) -> str:
        return f"<Animation: {self.frames} frames, {len(self.content) / 1e3:.0f} kB GIF>"

    def _repr_html_(self) -> str:
        return image_html(self.content, kind="gif", text=repr(self))
