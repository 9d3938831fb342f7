"""Paths between two ends: all of them with their gains, and one explained in decibels."""

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.em.decibels import decibels
from octant.em.fields.explain import BudgetLine, PathBudget, explain_path
from octant.em.fields.gains import PathGains, path_gains
from octant.em.medium.radio_scene import RadioScene
from octant.em.paths.tracing import trace_paths
from octant.em.records import PathSet
from octant.em.search.candidates import Candidates
from octant.geometries.errors import ConfigError, PhysicsWarning
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.face.shown import text_html
from octant.reader_design.setting.advice import solid_wall_notes
from octant.reader_design.setting.antennas import named_antenna
from octant.reader_design.setting.placing import place_antenna
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.showing.netcdf import variable
from octant.reader_design.showing.scene_picture import ColourBy, DrawnPaths, View, scene_figure
from octant.reader_design.showing.tables import put_table
from octant.reader_design.study_file.schema import Study

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

FloatArray = npt.NDArray[np.float64]
Point = tuple[float, float, float]
Block = tuple[int, PathSet, PathGains]
"""Number of the first receiver of a block, the paths to its receivers, and their gains."""

PATH_COLUMNS = (
    "rx",
    "path",
    "order",
    "interactions",
    "length_m",
    "delay_ns",
    "departure_theta_deg",
    "departure_phi_deg",
    "arrival_theta_deg",
    "arrival_phi_deg",
    "gain_db",
    "phase_deg",
    "vertices",
)
BUDGET_COLUMNS = (
    "step",
    "change_db",
    "level_db",
    "element",
    "material",
    "incidence_deg",
    "te_db",
    "te_phase_deg",
    "tm_db",
    "tm_phase_deg",
    "te_share",
    "x_m",
    "y_m",
    "z_m",
    "detail",
)
NANOSECONDS_PER_SECOND = 1e9
RECEIVERS_PER_BLOCK = 512


@dataclass(frozen=True, slots=True, kw_only=True)
class End:
    """The antenna at one end of the paths.

    Parameters
    ----------
    place_key, antenna_key : The arguments that give place and antenna, for messages.
    antenna : A kind of antenna or a pattern file.
    axis, azimuth_deg : Its direction (None: up, a patch down), and the turn about it [deg].
    """

    place_key: str
    antenna_key: str
    antenna: str = "dipole"
    axis: Point | None = None
    azimuth_deg: float = 0.0

    def made(self, frequency_hz: float) -> Antenna:
        """Return the antenna in the room's frame.

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        """
        return named_antenna(
            self.antenna,
            frequency_hz,
            key=self.antenna_key,
            axis=self.axis,
            azimuth_deg=self.azimuth_deg,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PathLink:
    """What is traced: scene, images of the transmitter, receivers and the two antennas.

    Parameters
    ----------
    setting, radio : The room with its tags; scene and materials at the frequency.
    candidates : Of the transmitter.
    receivers_m : (m, 3) float64 — Places of the receivers, after the stand-off [m].
    transmitter, receiver : Antennas in the room's frame.
    notes : Which antennas lay on a surface and were moved off it.
    """

    setting: Setting
    radio: RadioScene
    candidates: Candidates
    receivers_m: FloatArray
    transmitter: Antenna
    receiver: Antenna
    notes: tuple[str, ...]

    @property
    def block_count(self) -> int:
        """Number of blocks."""
        return -(-len(self.receivers_m) // RECEIVERS_PER_BLOCK)

    def blocks(self) -> Iterator[Block]:
        """Yield the paths to some hundred receivers at a time, so that memory stays small."""
        for first in range(0, len(self.receivers_m), RECEIVERS_PER_BLOCK):
            block = self.receivers_m[first : first + RECEIVERS_PER_BLOCK]
            found = trace_paths(self.radio, self.candidates, block)
            gains = path_gains(
                self.radio, found, transmitter=self.transmitter, receiver=self.receiver
            )
            yield first, found, gains

    def ray_attributes(self) -> dict[str, float]:
        """Return what rays have not found of the power ([-], [dB]); empty: all paths are found."""
        share = self.candidates.images.rays
        return {} if share is None else share.attributes()

    def explained(self, found: PathSet, path: int) -> PathBudget:
        """Return the budget of one path [dB].

        Parameters
        ----------
        found, path : Paths of a block, and the row of one of them.
        """
        return explain_path(
            self.radio, found, path, transmitter=self.transmitter, receiver=self.receiver
        )


def path_link(
    study: Study,
    tx_m: npt.ArrayLike,
    receivers_m: npt.ArrayLike,
    *,
    tx: End,
    rx: End,
    max_reflections: int | None = None,
) -> PathLink:
    """Return the link between two ends in a study's room; refuse an end in the wrong place.

    Parameters
    ----------
    study : Its room, carrier and solver.
    tx_m, receivers_m : (3,) and (m, 3) array_like — Transmitter and receivers [m].
    tx, rx : Transmitting and receiving antenna.
    max_reflections : Highest order; None: the study's.
    """
    setting = build_setting(study)
    standoff_m = study.solver.standoff_m
    source, note = place_antenna(
        setting.scene, tx_m, standoff_m, name="transmitter", key=tx.place_key
    )
    given = np.asarray(receivers_m, dtype=np.float64).reshape(-1, 3)
    receivers, moved = setting.scene.stand_off(given, standoff_m)
    notes = [
        f"receiver {i} at {given[i].tolist()} m lies on a surface and is moved off it, "
        f"to {np.round(receivers[i], 9).tolist()} m (solver.standoff_m)."
        for i in np.flatnonzero(moved)
    ]
    _refuse_same_place(source, receivers)
    _warn_of_outside(setting.scene, receivers, key=rx.place_key)
    frequency_hz = study.radio.frequency_hz
    radio = setting.radio_at(frequency_hz)
    found = setting.candidates(
        source,
        radio=radio,
        max_reflections=max_reflections,
        region_m=_region(setting.scene, source, receivers),
        receivers_m=receivers,
    )
    return PathLink(
        setting=setting,
        radio=radio,
        candidates=found,
        receivers_m=receivers,
        transmitter=tx.made(frequency_hz),
        receiver=rx.made(frequency_hz),
        notes=tuple(filter(None, (note, *notes, *solid_wall_notes(study, setting.scene)))),
    )


def _refuse_same_place(source_m: FloatArray, receivers_m: FloatArray) -> None:
    distance_m = np.linalg.norm(receivers_m - source_m, axis=1)
    nearest = int(np.argmin(distance_m))
    if distance_m[nearest] < LENGTHS.place_m:
        msg = (
            f"receiver {nearest} stands at the transmitter's own place {source_m.tolist()} m, "
            "where no path has a length; move one of them."
        )
        raise ConfigError(msg)


def _warn_of_outside(scene: Scene, receivers_m: FloatArray, *, key: str) -> None:
    """Warn of receivers outside the room, which walls may hide from every path."""
    outside = np.flatnonzero(~scene.inside_room(receivers_m))
    if len(outside):
        low, high = (tuple(np.round(corner, 3).tolist()) for corner in scene.bounds_m)
        more = f" and {len(outside) - 1} more are" if len(outside) > 1 else " is"
        place = tuple(receivers_m[outside[0]].tolist())
        msg = (
            f"receiver {outside[0]} at {place} m{more} outside the room that spans {low} to "
            f"{high} m ({key}): only paths through openings and penetrable walls arrive there."
        )
        warnings.warn(msg, PhysicsWarning, stacklevel=3)


def _region(scene: Scene, source_m: FloatArray, receivers_m: FloatArray) -> FloatArray | None:
    """Return a box around everything when a receiver is outside the scene, else None."""
    low, high = scene.bounds_m
    if bool(((receivers_m >= low) & (receivers_m <= high)).all()):
        return None
    points = np.concatenate([scene.bounds_m, source_m[None, :], receivers_m])
    return np.stack([points.min(axis=0), points.max(axis=0)])


def receiver_sums(block: Block) -> FloatArray:
    """Return for each receiver of a block the number of paths, |sum g|^2 and sum |g|^2 [-].

    Parameters
    ----------
    block : From `PathLink.blocks`.
    """
    _, found, gains = block
    count = len(found.receivers_m)
    field = np.zeros(count, dtype=np.complex128)
    np.add.at(field, found.receiver, gains.gain)
    power = np.zeros(count)
    np.add.at(power, found.receiver, np.abs(gains.gain) ** 2)
    return np.column_stack(
        (np.bincount(found.receiver, minlength=count), np.abs(field) ** 2, power)
    )


def path_rows(block: Block) -> Iterator[Sequence[object]]:
    """Yield a row of `PATH_COLUMNS` for each path of a block.

    Parameters
    ----------
    block : From `PathLink.blocks`.
    """
    first, found, gains = block
    departure, arrival = _angles_deg(gains.departure), _angles_deg(gains.arrival)
    delay_ns = NANOSECONDS_PER_SECOND * gains.delay_s
    gain_db, phase_deg = decibels(np.abs(gains.gain) ** 2), np.angle(gains.gain, deg=True)
    number = np.arange(len(found)) - np.searchsorted(found.receiver, found.receiver)
    for k in range(len(found)):
        yield (
            first + int(found.receiver[k]),
            int(number[k]),
            int(found.order[k]),
            ",".join(found.letters_of(k)),
            float(gains.length_m[k]),
            float(delay_ns[k]),
            *departure[k].tolist(),
            *arrival[k].tolist(),
            float(gain_db[k]),
            float(phase_deg[k]),
            ";".join(":".join(repr(c) for c in v) for v in found.vertices_of(k).tolist()),
        )


def summary_lines(link: PathLink, sums: FloatArray, *, most: int | None = None) -> Iterator[str]:
    """Yield what a person wants to read: the gains by receiver [dB].

    Parameters
    ----------
    link : What was traced.
    sums : (m, 3) float64 — From `receiver_sums`, of all receivers [-].
    most : Receivers that are listed; None: all.
    """
    coherent_db, power_db = decibels(sums[:, 1]), decibels(sums[:, 2])
    names = ("rx", "x_m", "y_m", "z_m", "paths", "coherent_db", "power_sum_db")
    widths = (6, 9, 9, 9, 6, 12, 13)
    yield " ".join(f"{name:>{width}}" for name, width in zip(names, widths, strict=True))
    shown = len(sums) if most is None else min(most, len(sums))
    for i in range(shown):
        x, y, z = link.receivers_m[i]
        yield (
            f"{i:>6} {x:>9.4f} {y:>9.4f} {z:>9.4f} {int(sums[i, 0]):>6} "
            f"{coherent_db[i]:>12.4f} {power_db[i]:>13.4f}"
        )
    if shown < len(sums):
        yield f"   ... and {len(sums) - shown} more receivers: see the CSV."
    yield f"{int(sums[:, 0].sum())} paths to {len(sums)} receiver{'' if len(sums) == 1 else 's'}."
    if link.candidates.images.rays is not None:
        yield link.candidates.images.rays.text()


def _angles_deg(directions: FloatArray) -> FloatArray:
    """Return (k, 2) angles [deg]: theta from +z, phi from +x towards +y in [0, 360)."""
    across = np.hypot(directions[:, 0], directions[:, 1])
    theta = np.degrees(np.arctan2(across, directions[:, 2]))
    phi = np.degrees(np.arctan2(directions[:, 1], directions[:, 0])) % 360.0
    return np.column_stack([theta, np.where(phi >= 360.0, 0.0, phi)])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Paths:
    """All paths from one transmitter to some receivers, numbered from 0 over all receivers.

    Parameters
    ----------
    link, blocks : What is traced; paths and gains, some hundred receivers at a time.
    """

    link: PathLink
    blocks: tuple[Block, ...]

    def __len__(self) -> int:
        return sum(len(found) for _, found, _ in self.blocks)

    @property
    def received(self) -> "xr.Dataset":
        """Number of paths, coherent gain and power sum [dB] of each receiver."""
        import xarray as xr

        sums = np.concatenate([receiver_sums(block) for block in self.blocks])
        place = self.link.receivers_m

        def row(values: npt.ArrayLike, units: str, long_name: str) -> "xr.Variable":
            return variable(["rx"], values, units=units, long_name=long_name)

        return xr.Dataset(
            {
                "paths": row(sums[:, 0].astype(np.int64), "1", "number of paths"),
                "coherent_db": row(decibels(sums[:, 1]), "dB", "|sum of the gains|^2"),
                "power_sum_db": row(decibels(sums[:, 2]), "dB", "sum of |gain|^2"),
            },
            coords={
                "rx": row(np.arange(len(place)), "1", "number of the receiver"),
                **{
                    f"{axis}_m": row(place[:, i], "m", f"{axis} of the receiver")
                    for i, axis in enumerate("xyz")
                },
            },
            attrs=self.link.ray_attributes(),
        )

    @property
    def data(self) -> "xr.Dataset":
        """Receiver, order, length, delay, angles and complex gain of each path, with units."""
        import xarray as xr

        found = [paths for _, paths, _ in self.blocks]
        gains = [g for _, _, g in self.blocks]

        def row(values: Sequence[npt.ArrayLike], units: str, long_name: str) -> "xr.Variable":
            joined = np.concatenate([np.asarray(v) for v in values])
            attributes = {"units": units, "long_name": long_name}
            return xr.Variable(["path"], joined, attrs=attributes)

        angles = {}
        for end in ("departure", "arrival"):
            both = [_angles_deg(getattr(g, end)) for g in gains]
            for i, angle in enumerate(("theta", "phi")):
                angles[f"{end}_{angle}"] = row(
                    [b[:, i] for b in both], "degree", f"{angle} of {end}"
                )
        return xr.Dataset(
            {
                "rx": row([i + p.receiver for i, p, _ in self.blocks], "1", "receiver"),
                "order": row([p.order for p in found], "1", "reflections and diffractions"),
                "length": row([g.length_m for g in gains], "m", "length"),
                "delay": row([g.delay_s for g in gains], "s", "delay"),
                **angles,
                "gain": row([g.gain for g in gains], "1", "complex gain between the antennas"),
            }
        )

    def to_dataframe(self) -> "pd.DataFrame":
        """Return a table with a row a path, as the command ``octant paths`` writes it."""
        import pandas as pd

        rows = [row for block in self.blocks for row in path_rows(block)]
        return pd.DataFrame(rows, columns=list(PATH_COLUMNS))

    def to_csv(self, path: str | Path, *, force: bool = False) -> None:
        """Write the same table as CSV.

        Parameters
        ----------
        path, force : The file; whether one that exists is replaced.
        """
        rows = (row for block in self.blocks for row in path_rows(block))
        put_table(str(path), PATH_COLUMNS, rows, force=force)

    def explain(self, path: int | None = None) -> "Explanation":
        """Return the budget of one path [dB].

        Parameters
        ----------
        path : Row of the path in `to_dataframe`; None: the strongest.
        """
        gain = np.concatenate([gains.gain for _, _, gains in self.blocks])
        if path is None and len(gain):
            path = int(np.argmax(np.abs(gain)))
        if path is None or not 0 <= path < len(gain):
            allowed = f"are numbered 0 to {len(gain) - 1}" if len(gain) else "are none"
            msg = f"the path asked for is {path}, but the paths {allowed}; choose another."
            raise ConfigError(msg)
        for _, found, gains in self.blocks:
            if path < len(found):
                return Explanation(
                    link=self.link,
                    found=found,
                    gains=gains,
                    path=path,
                    budget=self.link.explained(found, path),
                )
            path -= len(found)
        raise AssertionError

    def strongest(self, most: int) -> DrawnPaths:
        """Return the strongest paths as a picture takes them; one receiver at a time makes sense.

        Parameters
        ----------
        most : Number of paths.
        """
        gain_db = decibels(np.abs(np.concatenate([g.gain for _, _, g in self.blocks])) ** 2)
        chosen = np.argsort(-gain_db, kind="stable")[:most]
        vertices = [p.vertices_of(k) for _, p, _ in self.blocks for k in range(len(p))]
        order = np.concatenate([p.order for _, p, _ in self.blocks])
        return DrawnPaths(
            vertices_m=tuple(vertices[k] for k in chosen),
            gain_db=gain_db[chosen],
            order=order[chosen],
            of=len(gain_db),
        )

    def ends_m(self) -> dict[str, FloatArray]:
        """Return the places of the transmitter and of the first receiver [m]."""
        return {
            "transmitter": self.link.candidates.images.source_m,
            "receiver": self.link.receivers_m[0],
        }

    def plot(
        self, *, most: int = 30, colour_by: ColourBy = "gain", view: View | None = None
    ) -> "Figure":
        """Return a picture of the room with the strongest paths.

        Parameters
        ----------
        most : Draw at most so many paths.
        colour_by, view : Their colour shows "gain" or "order"; from where the room is seen.
        """
        setting, drawn = self.link.setting, self.strongest(most)
        return scene_figure(
            setting.scene,
            title=paths_title(setting, drawn, frequency_hz=self.link.radio.frequency_hz),
            tags={tag.id: tag.position_m for tag in setting.tags},
            ends_m=self.ends_m(),
            paths=drawn,
            colour_by=colour_by,
            view=view,
        )

    def __repr__(self) -> str:
        receivers = len(self.link.receivers_m)
        text = f"<Paths: {len(self)} paths to {receivers} receiver{'' if receivers == 1 else 's'}"
        if receivers == 1:
            level = float(self.received["coherent_db"][0])
            text += f", coherent gain {level:.2f} dB"
        return text + f", {self.link.radio.frequency_hz / 1e9:g} GHz>"

    def _repr_html_(self) -> str:
        sums = np.concatenate([receiver_sums(block) for block in self.blocks])
        return text_html("\n".join(summary_lines(self.link, sums, most=20)))


def paths_title(setting: Setting, paths: DrawnPaths, *, frequency_hz: float) -> str:
    """Return the title of a picture with paths.

    Parameters
    ----------
    setting, paths, frequency_hz : The room, what is drawn, and the frequency [Hz].
    """
    shown = len(paths.order)
    what = f"all {shown} paths" if shown == paths.of else f"{shown} strongest of {paths.of} paths"
    return f"{setting.name}: {what}, {frequency_hz / 1e9:g} GHz"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Explanation:
    """The budget of one path, interaction by interaction.

    Parameters
    ----------
    link : Room, ends and antennas.
    found, gains, path : The path and its neighbours, their gains, and its row among them.
    budget : Its lines add up to the path's gain [dB].
    """

    link: PathLink
    found: PathSet
    gains: PathGains
    path: int
    budget: PathBudget

    def rows(self) -> Iterator[Sequence[object]]:
        """Yield a row of `BUDGET_COLUMNS` for each step; what a step does not have is None."""
        level = 0.0
        for line in self.budget.lines:
            level += line.change_db
            both = [None] * 4 if line.te is None or line.tm is None else [
                _db(line.te), _deg(line.te), _db(line.tm), _deg(line.tm)
            ]  # fmt: skip
            incidence = None if line.incidence_rad is None else math.degrees(line.incidence_rad)
            yield (
                line.step,
                line.change_db,
                level,
                line.element,
                line.material,
                incidence,
                *both,
                line.te_share,
                *(line.place_m or (None, None, None)),
                line.detail,
            )

    def to_dataframe(self) -> "pd.DataFrame":
        """Return a table with a row a step, as the command ``octant explain`` writes it."""
        import pandas as pd

        return pd.DataFrame(list(self.rows()), columns=list(BUDGET_COLUMNS))

    def lines(self) -> Iterator[str]:
        """Yield the budget as people read it."""
        found, gains, chosen = self.found, self.gains, self.path
        strength = np.abs(gains.gain)
        rank = int((strength > strength[chosen]).sum()) + 1
        order = int(found.order[chosen])
        of_order = "line of sight" if order == 0 else f"order {order}"
        yield (
            f"path {chosen} of {len(found)} ({of_order}; rank {rank} by power), "
            f"{self.link.radio.frequency_hz / 1e9:g} GHz"
        )
        yield (
            f"length {gains.length_m[chosen]:.6g} m, delay "
            f"{NANOSECONDS_PER_SECOND * gains.delay_s[chosen]:.6g} ns"
        )
        places = (f"({x:.4g}, {y:.4g}, {z:.4g})" for x, y, z in found.vertices_of(chosen))
        yield " -> ".join(places) + " m"
        yield ""
        yield from self._table()

    def _table(self) -> Iterator[str]:
        budget = self.budget
        width = max(len(line.detail) for line in budget.lines) + 1
        coefficients = f"{'incid.':>7} {'TE':>15} {'TM':>15} {'in TE':>6}"
        yield f"{'':<19}{'':<{width}} {coefficients} {'change':>9} {'level':>9}"
        yield (
            f"{'':<19}{'':<{width}} {'deg':>7} {'dB':>8} {'deg':>6} {'dB':>8} {'deg':>6} {'%':>6} "
            f"{'dB':>9} {'dB':>9}"
        )
        level = 0.0
        for line in budget.lines:
            level += line.change_db
            yield (
                f"{line.step:<19}{line.detail:<{width}} {_coefficients(line)} "
                f"{line.change_db:>+9.3f} {level:>9.3f}"
            )
        phase = math.degrees(math.atan2(budget.gain.imag, budget.gain.real))
        yield f"{'together':<19}gain {budget.gain_db:.3f} dB, phase {phase:.2f} deg"

    def __repr__(self) -> str:
        return "\n".join(self.lines())

    def _repr_html_(self) -> str:
        return text_html(repr(self))


def _coefficients(line: BudgetLine) -> str:
    if line.te is None or line.tm is None or line.incidence_rad is None:
        return " " * 46
    share = "" if line.te_share is None else f"{100.0 * line.te_share:.0f}"
    te, tm = (f"{_db(c):>8.2f} {_deg(c):>6.1f}" for c in (line.te, line.tm))
    return f"{math.degrees(line.incidence_rad):>7.2f} {te} {tm} {share:>6}"


def _db(coefficient: complex) -> float:
    return 20.0 * math.log10(abs(coefficient)) if coefficient else -math.inf


def _deg(coefficient: complex) -> float:
    return math.degrees(math.atan2(coefficient.imag, coefficient.real))
