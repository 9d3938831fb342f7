"""The curves of thesis chapters 6 and 7, a U-shape, and splines through waypoints."""

import math
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.geometries.tolerances import LENGTHS
from octant.navigation.tracking.trajectories import Curve

FloatArray = npt.NDArray[np.float64]
Graph = Callable[[FloatArray], tuple[FloatArray, FloatArray, FloatArray]]
"""x to y, dy/dx and d²y/dx²."""


def fixed_pose(pose: npt.ArrayLike, *, duration_s: float = 60.0) -> Curve:
    """Return a curve that stays at one pose: point stabilisation, thesis 7.5.1.1.

    Parameters
    ----------
    pose : (3,) float64 — x [m], y [m], heading [rad].
    duration_s : How long [s].
    """
    at = frozen_array(pose, name="pose", shape=(3,), error=NavigationError)

    def motion(time_s: FloatArray) -> FloatArray:
        still = np.zeros((3, len(time_s), 2))
        still[0] = at[:2]
        return still

    return Curve(
        name="point", duration_s=duration_s, motion=motion, resting_heading_rad=float(at[2])
    )


def graph(name: str, along: Graph, *, x_range_m: tuple[float, float], duration_s: float) -> Curve:
    """Return the graph of a function, passed at a steady dx/dt.

    Parameters
    ----------
    name : What it is called.
    along : x (k,) [m] to y [m], dy/dx and d²y/dx² [1/m].
    x_range_m : (2,) tuple of float — First and last x [m].
    duration_s : How long it takes [s].
    """
    first, last = x_range_m
    rate = (last - first) / duration_s

    def motion(time_s: FloatArray) -> FloatArray:
        x = first + rate * time_s
        y, slope, bend = along(x)
        flat = np.zeros_like(x)
        return np.stack(
            [
                np.column_stack([x, y]),
                np.column_stack([flat + rate, rate * slope]),
                np.column_stack([flat, rate**2 * bend]),
            ]
        )

    return Curve(name=name, duration_s=duration_s, motion=motion)


def line(
    start_m: tuple[float, float] = (-4.0, -4.0),
    end_m: tuple[float, float] = (4.0, 4.0),
    *,
    duration_s: float = 60.0,
) -> Curve:
    """Return a straight line at constant speed; the defaults are those of thesis 6.5.3.

    Parameters
    ----------
    start_m, end_m : (2,) tuple of float — Its ends [m].
    duration_s : How long it takes [s].
    """
    begin, way = np.array(start_m), np.subtract(end_m, start_m)

    def motion(time_s: FloatArray) -> FloatArray:
        share = (time_s / duration_s)[:, None]
        still = np.zeros((len(time_s), 2))
        return np.stack([begin + share * way, still + way / duration_s, still])

    return Curve(name="line", duration_s=duration_s, motion=motion)


def sine(*, duration_s: float = 60.0) -> Curve:
    """Return y = 3 sin(1.2 x) from x = -3 to 3 m, thesis 6.5.4.

    Parameters
    ----------
    duration_s : How long it takes [s].
    """

    def along(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        wave = np.sin(1.2 * x)
        return 3.0 * wave, 3.6 * np.cos(1.2 * x), -4.32 * wave

    return graph("sine", along, x_range_m=(-3.0, 3.0), duration_s=duration_s)


def sigmoid(*, duration_s: float = 60.0) -> Curve:
    """Return the step from y = -5 to 5 m with w = 0.7 m, x from -5 to 5 m, thesis 7.5.1.2.

    Parameters
    ----------
    duration_s : How long it takes [s].
    """
    rise_m, width_m = 10.0, 0.7

    def along(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        share = 1.0 / (1.0 + np.exp(-x / width_m))
        slope = share * (1.0 - share) * rise_m / width_m
        return -5.0 + rise_m * share, slope, slope * (1.0 - 2.0 * share) / width_m

    return graph("sigmoid", along, x_range_m=(-5.0, 5.0), duration_s=duration_s)


def parabola(*, duration_s: float = 60.0) -> Curve:
    """Return y = 0.4 x² from x = -5 to 5 m, thesis 7.5.1.2.

    Parameters
    ----------
    duration_s : How long it takes [s].
    """

    def along(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        return 0.4 * x**2, 0.8 * x, np.full_like(x, 0.8)

    return graph("parabola", along, x_range_m=(-5.0, 5.0), duration_s=duration_s)


def _harmonic(name: str, terms: Sequence[tuple[float, int, float]], *, duration_s: float) -> Curve:
    """Return x and y as A sin(n w t + phase), w one turn over the duration: (A, n, phase) each."""
    base = 2.0 * math.pi / duration_s

    def motion(time_s: FloatArray) -> FloatArray:
        columns = []
        for amplitude, number, phase in terms:
            rate = number * base
            angle = rate * time_s + phase
            value = amplitude * np.sin(angle)
            columns.append([value, amplitude * rate * np.cos(angle), -(rate**2) * value])
        return np.moveaxis(np.array(columns), 0, -1)

    return Curve(name=name, duration_s=duration_s, motion=motion)


def ellipse(*, half_axes_m: tuple[float, float] = (4.0, 2.0), duration_s: float = 60.0) -> Curve:
    """Return an ellipse around the origin, once, counter-clockwise from +x, thesis 7.5.1.3.

    Parameters
    ----------
    half_axes_m : (2,) tuple of float — Along x and y [m].
    duration_s : How long it takes [s].
    """
    along_x, along_y = half_axes_m
    terms = ((along_x, 1, 0.5 * math.pi), (along_y, 1, 0.0))
    return _harmonic("ellipse", terms, duration_s=duration_s)


def lemniscate(*, size_m: float = 3.0, duration_s: float = 60.0) -> Curve:
    """Return the figure of eight of thesis 7.5.2.2: x = A sin(w t), y = A sin(2 w t), once.

    Parameters
    ----------
    size_m : A [m].
    duration_s : How long it takes [s].
    """
    return _harmonic("lemniscate", ((size_m, 1, 0.0), (size_m, 2, 0.0)), duration_s=duration_s)


def repeated(curve: Curve, laps: int) -> Curve:
    """Return a closed curve, driven again and again.

    Parameters
    ----------
    curve : It ends where, and as fast as, it begins.
    laps : How often.
    """
    ends = curve.motion(np.array([0.0, curve.duration_s]))[:2]
    if laps < 1 or not np.allclose(ends[:, 0], ends[:, 1], rtol=0.0, atol=1e-6):
        msg = (
            f"{curve.name!r} shall be driven {laps} times, but it must end as it begins, place and "
            "velocity, and be driven at least once: take a closed curve."
        )
        raise NavigationError(msg)

    def motion(time_s: FloatArray) -> FloatArray:
        return curve.motion(np.mod(time_s, curve.duration_s))

    return Curve(name=curve.name, duration_s=laps * curve.duration_s, motion=motion)


def placed(curve: Curve, origin_m: tuple[float, float], turn_rad: float) -> Curve:
    """Return a curve turned about its origin, and then moved.

    Parameters
    ----------
    curve : What is placed.
    origin_m : (2,) tuple of float — Where its origin goes [m].
    turn_rad : By how much it is turned, counter-clockwise [rad].
    """
    cos, sin = math.cos(turn_rad), math.sin(turn_rad)
    turned = np.array([[cos, sin], [-sin, cos]])

    def motion(time_s: FloatArray) -> FloatArray:
        moved: FloatArray = curve.motion(time_s) @ turned
        moved[0] += origin_m
        return moved

    return Curve(
        name=curve.name,
        duration_s=curve.duration_s,
        motion=motion,
        resting_heading_rad=curve.resting_heading_rad + turn_rad,
    )


def u_shape(
    legs_m: tuple[float, float, float] = (7.5, 4.0, 5.0),
    *,
    corner_radius_m: float = 0.5,
    duration_s: float = 60.0,
) -> Curve:
    """Return three legs with two left turns, at constant speed, from the origin along +x.

    Parameters
    ----------
    legs_m : (3,) tuple of float — Lengths between the corners [m]; those of thesis 7.6.2.
    corner_radius_m : Radius of the corners [m]; a robot that does not stop cannot take a sharp one.
    duration_s : How long it takes [s].
    """
    first, middle, last = legs_m
    if not (corner_radius_m > 0.0 and corner_radius_m <= min(first, 0.5 * middle, last)):
        msg = (
            f"corner_radius_m is {corner_radius_m} m, but it must be positive and fit legs of "
            f"{first:g}, {middle:g} and {last:g} m: take a smaller one."
        )
        raise NavigationError(msg)
    r = corner_radius_m
    quarter = 0.5 * math.pi * r
    lengths = np.array([first - r, quarter, middle - 2.0 * r, quarter, last - r])
    bends = np.array([0.0, 1.0 / r, 0.0, 1.0 / r, 0.0])
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    headings = np.concatenate([[0.0], np.cumsum(bends * lengths)])
    speed = ends[-1] / duration_s

    def motion(time_s: FloatArray) -> FloatArray:
        way = np.clip(speed * time_s, 0.0, ends[-1])
        piece = np.clip(np.searchsorted(ends, way, side="right") - 1, 0, len(bends) - 1)
        heading = headings[piece] + bends[piece] * (way - ends[piece])
        chord = _piece_chords(lengths, headings[:-1], bends * lengths)
        origins = np.vstack([np.zeros((1, 2)), np.cumsum(chord, axis=0)])
        inside = _piece_chords(
            way - ends[piece], headings[piece], bends[piece] * (way - ends[piece])
        )
        direction = np.column_stack([np.cos(heading), np.sin(heading)])
        left = np.column_stack([-np.sin(heading), np.cos(heading)])
        return np.stack(
            [origins[piece] + inside, speed * direction, speed**2 * bends[piece][:, None] * left]
        )

    return Curve(name="u-shape", duration_s=duration_s, motion=motion)


def _piece_chords(length: FloatArray, heading: FloatArray, turn: FloatArray) -> FloatArray:
    chord = length * np.sinc(turn / (2.0 * np.pi))
    along = heading + 0.5 * turn
    return np.column_stack([chord * np.cos(along), chord * np.sin(along)])


def spline(
    waypoints_m: npt.ArrayLike, *, duration_s: float, closed: bool = False, name: str = "spline"
) -> Curve:
    """Return a cubic spline in time through waypoints, passed in shares of time like their chords.

    Parameters
    ----------
    waypoints_m : (k, 2) float64 — The points [m], at least two, no two neighbours alike.
    duration_s : How long it takes [s].
    closed : Go back to the first point, without a kink there.
    name : What it is called.
    """
    from scipy.interpolate import CubicSpline

    points = frozen_array(waypoints_m, name="waypoints_m", shape=(None, 2), error=NavigationError)
    way = np.vstack([points, points[:1]]) if closed else np.array(points)
    chords = np.linalg.norm(np.diff(way, axis=0), axis=1)
    if len(points) < 2 + closed or not (chords > LENGTHS.same_m).all():
        msg = (
            f"{name!r} has {len(points)} waypoints, but a spline needs at least {2 + closed} and "
            "no two neighbours alike: change the list."
        )
        raise NavigationError(msg)
    times = duration_s * np.concatenate([[0.0], np.cumsum(chords)]) / chords.sum()
    ends = "periodic" if closed else "natural"
    curve = CubicSpline(times, way, bc_type=ends)

    def motion(time_s: FloatArray) -> FloatArray:
        return np.stack([curve(time_s), curve(time_s, 1), curve(time_s, 2)])

    return Curve(name=name, duration_s=duration_s, motion=motion)
