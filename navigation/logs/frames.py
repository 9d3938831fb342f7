"""Coordinates of a log turned, shifted and mirrored onto a room, by given or fitted values."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.logs.records import Log

FloatArray = npt.NDArray[np.float64]

_SAME_SCALE = 0.1
_LEAST_SPREAD = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """How places of a log lie in a room: p_room = R(turn) M p_log + shift.

    Parameters
    ----------
    turn_rad : Turn R, counter-clockwise [rad].
    shift_m : (2,) float64 — Where the log's origin lies in the room [m].
    mirrored : Whether M changes the sign of y first.
    """

    turn_rad: float = 0.0
    shift_m: FloatArray
    mirrored: bool = False

    def __post_init__(self) -> None:
        shift = frozen_array(self.shift_m, name="shift_m", shape=(2,), error=NavigationError)
        object.__setattr__(self, "shift_m", shift)

    @property
    def same(self) -> bool:
        """Return whether nothing moves."""
        return self.turn_rad == 0.0 and not self.mirrored and not self.shift_m.any()

    @property
    def _linear(self) -> FloatArray:
        c, s = math.cos(self.turn_rad), math.sin(self.turn_rad)
        sign = -1.0 if self.mirrored else 1.0
        return np.array([[c, -s * sign], [s, c * sign]])

    def places_m(self, places_m: npt.ArrayLike) -> FloatArray:
        """Return places in the room, (..., 2) [m].

        Parameters
        ----------
        places_m : (..., 2) float64 — Places of the log [m].
        """
        return np.asarray(places_m, dtype=np.float64) @ self._linear.T + self.shift_m

    def headings_rad(self, headings_rad: npt.ArrayLike) -> FloatArray:
        """Return headings in the room [rad].

        Parameters
        ----------
        headings_rad : (...) float64 — Headings of the log [rad].
        """
        sign = -1.0 if self.mirrored else 1.0
        return np.asarray(self.turn_rad + sign * np.asarray(headings_rad, dtype=np.float64))

    def text(self) -> str:
        """Return the frame as keys of the table [log] ([deg], [m])."""
        x, y = (f"{v:.6g}" for v in self.shift_m)
        turn = f"turn_deg = {math.degrees(self.turn_rad):.6g}"
        return f"{turn}, shift_m = [{x}, {y}], mirrored = {str(self.mirrored).lower()}"


UNMOVED = Frame(shift_m=np.zeros(2))
"""The frame of a log that is in the room's coordinates already."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FittedFrame:
    """A frame found from reference points.

    Parameters
    ----------
    frame : The frame.
    rms_m : Root of the mean squared distance that is left between the points [m].
    mirror_decided : Whether the points say if the log is mirrored: there are three or more, not on
        one line.
    """

    frame: Frame
    rms_m: float
    mirror_decided: bool


def fitted_frame(
    log_m: npt.ArrayLike, room_m: npt.ArrayLike, *, mirrored: bool | None = None
) -> FittedFrame:
    """Return the frame that lays points of a log onto points of a room with least squares.

    Parameters
    ----------
    log_m, room_m : (k, 2) float64 — The same two or more points in the log's frame and the room's
        [m].
    mirrored : Whether the log is mirrored; None: whatever fits better, which needs three points
        that lie on no line.

    Raises
    ------
    NavigationError
        There are too few points, they coincide, or the distances between them differ by more than
        a tenth between log and room: a frame does not scale.

    Notes
    -----
    With points as complex numbers about their means, p of the log and q of the room, the turn that
    maximises Re Σ conj(q) e^{jα} p is α = arg Σ q conj(p); of the mirrored log p is its conjugate.

    References
    ----------
    W. Kabsch, Acta Crystallographica A 32 (1976) 922: the same in three dimensions.
    """
    ours, theirs = (
        frozen_array(points, name=name, shape=(None, 2), error=NavigationError)
        for points, name in ((log_m, "points of the log"), (room_m, "points of the room"))
    )
    if len(ours) != len(theirs) or len(ours) < 2:
        msg = (
            f"{len(ours)} points of the log and {len(theirs)} of the room are given, but a frame "
            "needs the same points in both, at least two; three where it may be mirrored."
        )
        raise NavigationError(msg)
    p, q = (points[:, 0] + 1j * points[:, 1] for points in (ours, theirs))
    p_mean, q_mean = p.mean(), q.mean()
    p, q = p - p_mean, q - q_mean
    spread_log, spread_room = (math.sqrt(float(np.mean(np.abs(v) ** 2))) for v in (p, q))
    if min(spread_log, spread_room) < _LEAST_SPREAD:
        msg = "the reference points coincide, so that they give no direction; take points apart."
        raise NavigationError(msg)
    if abs(math.log(spread_room / spread_log)) > _SAME_SCALE:
        msg = (
            f"the reference points lie {spread_room / spread_log:.4g} times as far apart in the "
            "room as in the log, but a frame does not scale; check them and the unit of lengths."
        )
        raise NavigationError(msg)
    decided = abs(complex(np.sum(p**2))) < (1.0 - 1e-6) * float(np.sum(np.abs(p) ** 2))
    if mirrored is None and not decided:
        msg = (
            "the reference points lie on one line, so that they do not say whether the log is "
            "mirrored; add one beside it, or say it by mirrored."
        )
        raise NavigationError(msg)
    found = []
    for flip in (False, True) if mirrored is None else (mirrored,):
        source, mean = (p.conj(), p_mean.conjugate()) if flip else (p, p_mean)
        turn = float(np.angle(np.sum(q * source.conj())))
        left = q - np.exp(1j * turn) * source
        shift = q_mean - np.exp(1j * turn) * mean
        frame = Frame(turn_rad=turn, shift_m=np.array([shift.real, shift.imag]), mirrored=flip)
        rms_m = math.sqrt(float(np.mean(np.abs(left) ** 2)))
        found.append(FittedFrame(frame=frame, rms_m=rms_m, mirror_decided=decided))
    return min(found, key=lambda one: one.rms_m)


def axis_frames(low_m: npt.ArrayLike, high_m: npt.ArrayLike) -> Mapping[str, Frame]:
    """Return what people mix up, by its name: axes swapped, mirrored, or turned [m].

    Mirrors and turns map a room's bounds onto themselves, or onto their centre where a quarter turn
    exchanges width and depth. `compare` and the check of poses try them on a log that does not fit.

    Parameters
    ----------
    low_m, high_m : (2,) float64 — Least and greatest x and y of the room [m].
    """
    middle = 0.5 * (np.asarray(low_m, dtype=np.float64) + np.asarray(high_m, dtype=np.float64))

    def about_middle(turn_rad: float, *, mirrored: bool) -> Frame:
        bare = Frame(turn_rad=turn_rad, shift_m=np.zeros(2), mirrored=mirrored)
        return replace(bare, shift_m=middle - bare.places_m(middle))

    half = 0.5 * np.pi
    return {
        "x and y exchanged": Frame(turn_rad=half, shift_m=np.zeros(2), mirrored=True),
        "x mirrored": about_middle(np.pi, mirrored=True),
        "y mirrored": about_middle(0.0, mirrored=True),
        "turned by 180 deg": about_middle(np.pi, mirrored=False),
        "turned by 90 deg": about_middle(half, mirrored=False),
        "turned by -90 deg": about_middle(-half, mirrored=False),
        "x and y exchanged and both mirrored": about_middle(-half, mirrored=True),
    }


def in_room(log: Log, frame: Frame) -> Log:
    """Return a log with its places and headings in a room's frame, headings in (-π, π] [m], [rad].

    Turns of the odometry change their sign where the frame is mirrored.

    Parameters
    ----------
    log : The log.
    frame : Its frame; `UNMOVED` changes nothing.
    """
    if frame.same:
        return log
    poses = np.column_stack(
        [
            frame.places_m(log.poses[:, :2]),
            wrap_angle(frame.headings_rad(log.poses[:, 2])),
        ]
    )
    turn = -log.turn_rad if frame.mirrored else log.turn_rad
    return replace(log, poses=poses, turn_rad=turn)
