"""A whole study as an object: what it asks, what it computes, and what it leaves in a folder."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import msgspec
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.geometries.files import refuse_overwrite, write_text
from octant.reader_design.face.mission import Mission
from octant.reader_design.face.paths import End, Paths, path_link
from octant.reader_design.face.reader import Reader, SolvedReader, solve_reader_of
from octant.reader_design.face.room import Room, scene_picture
from octant.reader_design.face.rss_map import MapWanted, map_rss, pose_dataset, with_dbm
from octant.reader_design.face.shown import figure_html, image_html, progress_of, text_html
from octant.reader_design.face.tables import Tag, plain, study_from
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.showing.mat_files import write_mat
from octant.reader_design.showing.netcdf import read_dataset
from octant.reader_design.study_file.loading import load_study, to_toml, vary
from octant.reader_design.study_file.schema import Study as StudyTables
from octant.reader_design.study_file.tables_read import check_tables

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from octant.reader_design.experiments.study.verdict import Verdict

DATA_FILES = ("results.nc", "sweep.nc", "tolerance.nc", "reader.nc", "map.nc")
"""The datasets that a folder of results may hold, the main one first."""


class Study:
    """A whole study: a room with tags, a reader, and what is to be found out about them.

    Parameters
    ----------
    room, tags : The room and the tags that hang in it.
    reader : The reader; by default that of the thesis.
    **tables : Mappings of keys: ``radio``, ``solver``, ``map``, ``mission``, ``robot``, ``sensor``,
        ``sweep``, ``scoring``, ``choice``, ``optimise``, ``tolerance``, ``track``, ``dock``; a list
        of them for ``layout``; and ``name`` and ``seed``.

    Examples
    --------
    >>> import octant
    >>> study = octant.Study(
    ...     octant.Room.box((5, 4, 3)),
    ...     tags=[octant.Tag("1", (2.0, 0.5, 2.9))],
    ...     reader=octant.Reader(response="isolated"),
    ... )
    >>> study
    <Study study: 1 tag, 8 dipole r_a = 10 cm h_p = 8 cm>
    >>> study.replaced({"antennas": 4}).reader.antennas
    4
    """

    __slots__ = ("tables",)
    tables: StudyTables

    def __init__(
        self,
        room: Room,
        *,
        tags: Sequence[Tag] = (),
        reader: Reader | None = None,
        **tables: Any,  # noqa: ANN401  tables of a study file
    ) -> None:
        if tags and "tag_power_w" not in tables.get("radio", {}):
            radio = {**tables.get("radio", {}), "tag_power_w": tags[0].power_w}
            tables = {**tables, "radio": radio}
        self.tables = study_from(
            "Study", {"room": room, "tag": list(tags), "reader": reader, **tables}
        )

    @classmethod
    def load(cls, file: str | Path | None = None, *, built_in: str = "office") -> Self:
        """Return the study of a study file, or one that comes with Octant.

        Parameters
        ----------
        file : The TOML file, or the name of a built-in study.
        built_in : Where no file is given: "office", "thesis", "track" or "dock".
        """
        return cls.of(load_study(file, built_in=built_in))

    @classmethod
    def of(cls, tables: StudyTables) -> Self:
        """Return the study of tables that have been checked.

        Parameters
        ----------
        tables : From `octant.reader_design.study_file.loading.load_study`.
        """
        made = cls.__new__(cls)
        made.tables = tables
        return made

    @property
    def room(self) -> Room:
        """The room."""
        return Room.of(self.tables.room)

    @property
    def reader(self) -> Reader:
        """The reader."""
        return Reader.of(self.tables.reader)

    @property
    def tags(self) -> tuple[Tag, ...]:
        """The tags."""
        power_w = self.tables.radio.tag_power_w
        return tuple(Tag.of(tag, power_w=power_w) for tag in self.tables.tags)

    @property
    def mission(self) -> Mission:
        """The drive of the table ``[mission]``."""
        return Mission.of(self.tables)

    def replaced(self, changes: Mapping[str, Any]) -> Self:
        """Return the study with other values in some places.

        Parameters
        ----------
        changes : Value by key, in its unit, as in ``[sweep]``, such as ``"radio.frequency_hz"``.
        """
        return type(self).of(vary(self.tables, plain(changes), directory=Path.cwd()))

    def to_toml(self, path: str | Path | None = None, *, force: bool = False) -> str:
        """Return the study file with every default written out.

        Parameters
        ----------
        path : Where it is written too; mesh files are then named relative to it.
        force : Replace a file that exists.
        """
        if path is None:
            return to_toml(self.tables)
        refuse_overwrite(Path(path), force=force)
        text = to_toml(self.tables, relative_to=Path(path).parent)
        write_text(Path(path), text)
        return text

    def paths(
        self,
        tx: npt.ArrayLike,
        rx: npt.ArrayLike,
        *,
        max_reflections: int | None = None,
        tx_antenna: str = "dipole",
        rx_antenna: str = "dipole",
    ) -> Paths:
        """Return every path between a transmitter and receivers in the study's room.

        Parameters
        ----------
        tx, rx : Transmitter, (3,), and receivers, (3,) or (m, 3) [m].
        max_reflections : Highest number of reflections and diffractions; by default the study's.
        tx_antenna, rx_antenna : As in `Room.paths`.
        """
        ends = {
            name: End(place_key=name, antenna_key=f"{name}_antenna", antenna=antenna)
            for name, antenna in (("tx", tx_antenna), ("rx", rx_antenna))
        }
        link = path_link(self.tables, tx, rx, **ends, max_reflections=max_reflections)
        return Paths(link=link, blocks=tuple(link.blocks()))

    def rss(self, poses: npt.ArrayLike, *, tags: Sequence[str] | None = None) -> "xr.Dataset":
        """Return what every antenna receives from the tags, pose by pose ([W] and [dBm]).

        Parameters
        ----------
        poses, tags : x, y [m] and heading [deg], (k, 3); names of the tags, by default all.
        """
        chosen = [tag.id for tag in self.tables.tags] if tags is None else list(tags)
        return pose_dataset(self.tables, chosen, poses)

    def rss_map(
        self,
        *,
        tags: Sequence[str] = (),
        antennas: Sequence[int] | None = None,
        heading_deg: float | None = None,
        isotropic: bool = False,
        local_mean: bool = False,
        local_mean_disc: bool = False,
        spreads: bool = False,
        progress: bool | Progress = True,
    ) -> "xr.Dataset":
        """Return what the reader receives over the floor ([W] and [dBm]), as ``octant map`` does.

        Parameters
        ----------
        tags, heading_deg : By default all; the mission's, or 90 [deg].
        antennas, local_mean, local_mean_disc, spreads, progress : As in `Room.rss_map`.
        isotropic : One ``isotropic_theta`` antenna receives, and no reader.
        """
        wanted = MapWanted(
            tag_ids=tuple(tags),
            antennas=None if antennas is None else tuple(antennas),
            heading_deg=heading_deg,
            isotropic=isotropic,
            local_mean=local_mean,
            local_mean_disc=local_mean_disc,
            spreads=spreads,
        )
        return with_dbm(map_rss(self.tables, wanted, progress=progress_of(progress))[0])

    def solve(self, *, step_deg: float = 2.0, progress: bool | Progress = True) -> SolvedReader:
        """Return the reader's ports and patterns at the carrier, as ``octant reader`` does.

        Parameters
        ----------
        step_deg, progress : As in `Reader.solve` [deg].
        """
        carrier = [self.tables.radio.frequency_hz]
        return solve_reader_of(
            self.tables, carrier, step_deg=step_deg, progress=progress_of(progress)
        )

    def plot(self) -> "Figure":
        """Return a picture of the room with its tags, and the reader where the mission starts."""
        return scene_picture(build_setting(self.tables))

    def run(
        self,
        out: str | Path,
        *,
        quick: bool = False,
        workers: int | None = 1,
        cluster: str | None = None,
        force: bool = False,
        progress: bool | Progress = True,
    ) -> "Results":
        """Return the results of the main job: sweep, choice, map, missions, report.

        Parameters
        ----------
        out : Folder of the results; the same call goes on where the last one stopped.
        quick : Coarse sampling, a coarse map and few runs.
        workers : Processes; None: one for each core. A script that starts processes must guard its
            main part with ``if __name__ == "__main__"``.
        cluster : Address of a dask scheduler, or ``local:N``; in place of ``workers``.
        force : Replace the results of another study in that folder.
        progress : False silences it.
        """
        from octant.reader_design.experiments.study.run import run_study

        run_study(
            self._for("study"),
            Path(out),
            quick=quick,
            force=force,
            progress=progress_of(progress),
            workers=workers,
            cluster=cluster,
        )
        return open_results(out)

    def sweep(
        self,
        out: str | Path,
        *,
        workers: int | None = 1,
        cluster: str | None = None,
        force: bool = False,
        progress: bool | Progress = True,
    ) -> "Results":
        """Return the scores of every combination of the values in the table ``[sweep]``.

        Parameters
        ----------
        out, workers, cluster, force, progress : As in `run`.
        """
        from octant.reader_design.experiments.sweep.compute import sweep_study

        sweep_study(
            self._for("sweep"),
            Path(out),
            workers=workers,
            cluster=cluster,
            force=force,
            progress=progress_of(progress),
        )
        return open_results(out)

    def optimise(
        self,
        out: str | Path,
        *,
        workers: int | None = 1,
        cluster: str | None = None,
        force: bool = False,
        progress: bool | Progress = True,
    ) -> "Results":
        """Return the results of the search for a reader that the table ``[optimise]`` asks for.

        Parameters
        ----------
        out, workers, cluster, force, progress : As in `run`.
        """
        from octant.reader_design.experiments.optimise.run import run_optimise

        run_optimise(
            self._for("optimise"),
            Path(out),
            workers=workers,
            cluster=cluster,
            force=force,
            progress=progress_of(progress),
        )
        return open_results(out)

    def tolerance(
        self,
        out: str | Path,
        *,
        samples: int | None = None,
        workers: int | None = 1,
        cluster: str | None = None,
        force: bool = False,
        progress: bool | Progress = True,
    ) -> "Results":
        """Return what build errors do to the reader, as the table ``[tolerance]`` asks for.

        Parameters
        ----------
        out, workers, cluster, force, progress : As in `run`.
        samples : Readers that are built; by default the study's.
        """
        from octant.reader_design.experiments.tolerance.run import run_tolerance

        run_tolerance(
            self._for("tolerance"),
            Path(out),
            samples=samples,
            workers=workers,
            cluster=cluster,
            force=force,
            progress=progress_of(progress),
        )
        return open_results(out)

    def track(
        self,
        out: str | Path,
        *,
        runs: int | None = None,
        seed: int | None = None,
        workers: int | None = 1,
        cluster: str | None = None,
        force: bool = False,
        progress: bool | Progress = True,
    ) -> "Results":
        """Return how controllers follow trajectories from RSS, as ``[track]`` asks for.

        Parameters
        ----------
        out, workers, cluster, force, progress : As in `run`.
        runs, seed : Repetitions of every drive and of SLAM, and seed; by default the study's.
        """
        from octant.reader_design.experiments.tracking.compute import (
            run_tracking,
            with_repetitions,
        )

        run_tracking(
            with_repetitions(self._for("track"), runs=runs, seed=seed),
            Path(out),
            workers=workers,
            cluster=cluster,
            force=force,
            progress=progress_of(progress),
        )
        return open_results(out)

    def dock(
        self,
        out: str | Path,
        *,
        runs: int | None = None,
        seed: int | None = None,
        workers: int | None = 1,
        cluster: str | None = None,
        force: bool = False,
        progress: bool | Progress = True,
    ) -> "Results":
        """Return how a robot docks at the station of the table ``[dock]``.

        Parameters
        ----------
        out, workers, cluster, force, progress : As in `run`.
        runs, seed : Runs in each room, and seed of all random numbers; by default the study's.
        """
        from octant.reader_design.experiments.docking.page import run_docking_study

        study = self._for("dock")
        if runs is not None:
            study = vary(study, {"dock.runs": runs})
        if seed is not None:
            study = msgspec.structs.replace(study, seed=seed)
        run_docking_study(
            study,
            Path(out),
            workers=workers,
            cluster=cluster,
            force=force,
            progress=progress_of(progress),
        )
        return open_results(out)

    @staticmethod
    def compare(
        file: str | Path,
        out: str | Path,
        *,
        runs: int | None = None,
        force: bool = False,
        progress: bool | Progress = True,
    ) -> "Results":
        """Return the missions of a comparison file: layouts, links, readers and controllers.

        Parameters
        ----------
        file, runs : One for ``octant navigate --compare``; runs of each, by default its own.
        out, force, progress : As in `run`.
        """
        from octant.reader_design.experiments.missions.comparison import run_comparison
        from octant.reader_design.experiments.missions.comparison_table import (
            load_comparison,
        )

        comparison = load_comparison(Path(file))
        if runs is not None:
            comparison = msgspec.structs.replace(comparison, runs=runs)
        run_comparison(comparison, Path(out), force=force, progress=progress_of(progress))
        return open_results(out)

    def _for(self, verb: str) -> StudyTables:
        check_tables(self.tables, verb)
        return self.tables

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Study) and self.tables == other.tables

    def __hash__(self) -> int:
        return hash(repr(self.tables))

    def __repr__(self) -> str:
        tags = len(self.tables.tags)
        reader = repr(self.reader).removeprefix("<Reader: ").rpartition(",")[0]
        return f"<Study {self.tables.name}: {tags} tag{'' if tags == 1 else 's'}, {reader}>"

    def _repr_html_(self) -> str:
        return text_html(repr(self)) + figure_html(self.plot())


@dataclass(frozen=True, slots=True)
class Results:
    """What a study left in a folder.

    Parameters
    ----------
    folder : The folder.
    """

    folder: Path

    @property
    def data(self) -> "xr.Dataset":
        """The main dataset, with units: ``results.nc``, or that of a sweep or of tolerances."""
        for name in DATA_FILES:
            if (self.folder / name).is_file():
                return read_dataset(self.folder / name)
        msg = f"{self.folder} holds no netCDF file; read one of its tables: {self._names()}."
        raise ConfigError(msg)

    @property
    def verdict(self) -> "Verdict":
        """What a study came to: a sentence, judged numbers, and what to try where it failed."""
        from octant.reader_design.experiments.study.verdict import Verdict

        text = self.data.attrs.get("verdict")
        if text is None:
            msg = f"{self.folder} holds no verdict, which only a study leaves (octant study)."
            raise ConfigError(msg)
        return msgspec.json.decode(text, type=Verdict)

    @property
    def study(self) -> Study:
        """The study, with every default resolved."""
        return Study.load(self.folder / "study.toml")

    @property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables."""
        return tuple(sorted(path.stem for path in self.folder.glob("*.csv")))

    @property
    def figures(self) -> tuple[Path, ...]:
        """The pictures."""
        return tuple(sorted((self.folder / "figures").glob("*.png")))

    @property
    def report(self) -> Path:
        """The page, where there is one."""
        return self.folder / "report.html"

    def to_mat(self, path: str | Path) -> None:
        """Write the main dataset as a MAT file for MATLAB, arrays by their names.

        Parameters
        ----------
        path : The file; replaced where it exists.
        """
        write_mat(self.data, Path(path))

    def table(self, name: str) -> "pd.DataFrame":
        """Return one of the tables.

        Parameters
        ----------
        name : One of ``tables``.
        """
        import pandas as pd

        if name not in self.tables:
            msg = f"{self.folder} holds no table {name!r}; choose one of {self._names()}."
            raise ConfigError(msg)
        frame: pd.DataFrame = pd.read_csv(self.folder / f"{name}.csv", comment="#")
        return frame

    def _names(self) -> str:
        return ", ".join(self.tables) or "no table"

    def __repr__(self) -> str:
        report = "a report, " if self.report.is_file() else ""
        return f"<Results in {self.folder}: {report}{len(self.figures)} figures, {self._names()}>"

    def _repr_html_(self) -> str:
        first = self.figures[:1]
        shown = "".join(image_html(path.read_bytes(), kind="png", text=path.stem) for path in first)
        return text_html(repr(self)) + shown


def open_results(folder: str | Path) -> Results:
    """Return the results that a study, a sweep or another experiment left in a folder.

    Parameters
    ----------
    folder : What was given as ``out``.

    Examples
    --------
    >>> import octant
    >>> octant.open_results("nothing-here")
    Traceback (most recent call last):
    ...
    octant.geometries.errors.ConfigError: nothing-here holds no results; give the folder of a study.
    """
    place = Path(folder)
    if not any((*place.glob("*.nc"), *place.glob("*.csv"))):
        msg = f"{place} holds no results; give the folder of a study."
        raise ConfigError(msg)
    return Results(place)
