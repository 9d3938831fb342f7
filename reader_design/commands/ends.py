"""What several verbs share that look at the paths between two ends: options, places, link."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click
import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.options import POINT

if TYPE_CHECKING:
    from octant.em.antennas.kinds import Antenna
    from octant.em.medium.radio_scene import RadioScene
    from octant.em.search.candidates import Candidates
    from octant.geometries.scene import Scene

Decorated = TypeVar("Decorated", bound=Callable[..., Any])
FloatArray = npt.NDArray[np.float64]
Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class EndAntenna:
    """The antenna that the options of one end name.

    Parameters
    ----------
    end : str
        ``tx`` or ``rx``, for messages.
    name : str
        A kind of antenna or a pattern file.
    axis : (3,) tuple of float or None
        Its direction; None: up, a patch down.
    azimuth_deg : float
        Turn about the axis [deg].
    """

    end: str
    name: str
    axis: Point | None
    azimuth_deg: float

    def made(self, frequency_hz: float) -> "Antenna":
        """Return the antenna in the room's frame.

        Parameters
        ----------
        frequency_hz : float
            Frequency [Hz].

        Returns
        -------
        Antenna
            Ready for paths.

        Raises
        ------
        ConfigError
            When there is no such antenna, or its angle is not finite.
        """
        from octant.reader_design.setting.antennas import named_antenna

        if not np.isfinite(self.azimuth_deg):
            msg = (
                f"--{self.end}-azimuth-deg is {self.azimuth_deg} degrees, but a finite number is "
                "needed."
            )
            raise ConfigError(msg)
        return named_antenna(
            self.name,
            frequency_hz,
            key=f"--{self.end}-antenna",
            axis=self.axis,
            azimuth_deg=self.azimuth_deg,
        )


def path_options(command: Decorated) -> Decorated:
    """Return a command that also takes the antennas at both ends and the order of its paths.

    Parameters
    ----------
    command : callable
        With the parameters ``antennas``, a pair of `EndAntenna`, and ``max_reflections``.

    Returns
    -------
    callable
        The same, with seven options.
    """

    @wraps(command)
    def with_antennas(
        *,
        tx_antenna: str,
        tx_axis: Point | None,
        tx_azimuth_deg: float,
        rx_antenna: str,
        rx_axis: Point | None,
        rx_azimuth_deg: float,
        **others: Any,  # noqa: ANN401  whatever else the command takes
    ) -> Any:  # noqa: ANN401
        sender = EndAntenna(end="tx", name=tx_antenna, axis=tx_axis, azimuth_deg=tx_azimuth_deg)
        taker = EndAntenna(end="rx", name=rx_antenna, axis=rx_axis, azimuth_deg=rx_azimuth_deg)
        return command(antennas=(sender, taker), **others)

    options: list[Any] = [
        click.option(
            "--max-reflections",
            type=click.IntRange(0, 12),
            help="Highest order; default: the study's.",
        )
    ]
    for end in ("tx", "rx"):
        options += [
            click.option(
                f"--{end}-antenna",
                default="dipole",
                show_default=True,
                help="dipole, monopole, patch, isotropic_theta or a pattern file.",
            ),
            click.option(
                f"--{end}-axis", type=POINT, help="Its direction; default: up, a patch down."
            ),
            click.option(
                f"--{end}-azimuth-deg", type=float, default=0.0, help="Turn about the axis [deg]."
            ),
        ]
    wrapped: Any = with_antennas
    for option in reversed(options):
        wrapped = option(wrapped)
    result: Decorated = wrapped
    return result


@dataclass(frozen=True, slots=True, kw_only=True)
class PathLink:
    """What is traced: scene, images of the transmitter, receivers and the two antennas.

    Parameters
    ----------
    radio : RadioScene
        Scene and materials at the study's carrier.
    candidates : Candidates
        Of the transmitter.
    receivers_m : (m, 3) float64
        Places of the receivers, after the stand-off [m].
    transmitter, receiver : Antenna
        Antennas in the room's frame.
    """

    radio: "RadioScene"
    candidates: "Candidates"
    receivers_m: FloatArray
    transmitter: "Antenna"
    receiver: "Antenna"


def study_link(
    study: Path,
    tx: Point,
    receivers_m: FloatArray,
    *,
    antennas: tuple[EndAntenna, EndAntenna],
    max_reflections: int | None,
    progress: Progress,
) -> PathLink:
    """Return the link between two ends in the room of a study, ready to be traced.

    Parameters
    ----------
    study : Path
        The study file.
    tx : (3,) tuple of float
        Transmitter [m].
    receivers_m : (m, 3) float64
        Receivers [m].
    antennas : pair of EndAntenna
        Transmitting and receiving.
    max_reflections : int or None
        Highest order; None: the study's.
    progress : Progress
        Told which antennas stand off a surface, and about compilation.

    Returns
    -------
    PathLink
        With every antenna that lay on a surface moved off it by ``solver.standoff_m``.

    Raises
    ------
    ConfigError
        When an end is in the wrong place, or there is no such antenna.
    """
    from octant.reader_design.setting.setting import (
        build_setting,
        candidates_from,
        place_antenna,
        radio_at,
    )
    from octant.reader_design.study_file.loading import load_study

    loaded = load_study(study)
    built = build_setting(loaded)
    standoff_m = loaded.solver.standoff_m
    source, note = place_antenna(built.scene, tx, standoff_m, name="transmitter", key="--tx")
    receivers, notes = _stood_off(built.scene, receivers_m, standoff_m)
    _refuse_same_place(source, receivers)
    for line in filter(None, (note, *notes)):
        progress.say(line)
    frequency_hz = loaded.radio.frequency_hz
    radio = radio_at(loaded, built, frequency_hz)
    found = candidates_from(
        loaded,
        radio,
        source,
        max_reflections=max_reflections,
        region_m=_region(built.scene, source, receivers),
    )
    return PathLink(
        radio=radio,
        candidates=found,
        receivers_m=receivers,
        transmitter=antennas[0].made(frequency_hz),
        receiver=antennas[1].made(frequency_hz),
    )


def _stood_off(
    scene: "Scene", receivers_m: FloatArray, standoff_m: float
) -> tuple[FloatArray, list[str]]:
    moved_to, moved = scene.stand_off(receivers_m, standoff_m)
    notes = [
        f"receiver {i} at {receivers_m[i].tolist()} m lies on a surface and is moved off it, "
        f"to {np.round(moved_to[i], 9).tolist()} m (solver.standoff_m)."
        for i in np.flatnonzero(moved)
    ]
    return moved_to, notes


def _refuse_same_place(source_m: FloatArray, receivers_m: FloatArray) -> None:
    distance_m = np.linalg.norm(receivers_m - source_m, axis=1)
    nearest = int(np.argmin(distance_m))
    if distance_m[nearest] < LENGTHS.place_m:
        msg = (
            f"receiver {nearest} stands at the transmitter's own place {source_m.tolist()} m, "
            "where there is no path to speak of; move one of them."
        )
        raise ConfigError(msg)


def _region(scene: "Scene", source_m: FloatArray, receivers_m: FloatArray) -> FloatArray | None:
    """Return a box around everything when a receiver is outside the scene, else None."""
    low, high = scene.bounds_m
    if bool(((receivers_m >= low) & (receivers_m <= high)).all()):
        return None
    points = np.concatenate([scene.bounds_m, source_m[None, :], receivers_m])
    return np.stack([points.min(axis=0), points.max(axis=0)])
