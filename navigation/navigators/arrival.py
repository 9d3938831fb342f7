"""When the robot is under the tag: the spread of the RSS, and why it fires only near the tag.

Under a vertical dipole nothing is received, so near the point under the tag the spread max z - min
z falls as the fourth power of the distance ρ (two dipoles). But it is small far away and in a
shadow too. The test therefore asks three things of a reading:

1. *small*: the spread is at most its value at the arrival radius R;

2. *possible*: with the equivalent distance r = R (s/s_R)^(1/4), every earlier reading has put the
tag at least r away, less a margin for noise, and the robot has since driven far enough to have come
within R. A faster fall of the spread is a shadow or a fade;

3. *crossed*: the spread has been well above its value at R since the leg began and since the last
impossible fall: the tag's main lobe has been entered. A robot that was under the tag then has also
arrived when it has driven 5 R since and dead reckoning finds it still within 2 R.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.sensing.sensor import PowerLink, unknown_tag

_NULL_EXPONENT = 4.0
_HOVER_DRIVEN_RADII = 5.0
_HOVER_AWAY_RADII = 2.0


def rss_spread_w(rss_w: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return the largest difference between two antennas, max z - min z [W].

    Parameters
    ----------
    rss_w : (..., n) float64 — RSS of the antennas [W].
    """
    return np.asarray(np.ptp(np.asarray(rss_w, dtype=np.float64), axis=-1))


@dataclass(frozen=True, slots=True, kw_only=True)
class ArrivalTest:
    """The arrival test of one tag.

    Thesis 5.2.2 step 3 says only "computing the differences between the RSS values across different
    antenna pairs" and 5.4.1 "approximately equal RSS values". The absolute spread is meant: one
    relative to the strongest antenna never fires. The test is deceived where the field fades out no
    faster than under a tag; then `metrics.measure` reports the run as captured.

    Parameters
    ----------
    threshold_w : Spread of the RSS at the arrival radius [W]; see `arrival_threshold_w`.
    radius_m : Arrival radius R around the point under the tag [m].
    arming_ratio : The spread must have been this many times the threshold on this leg [-], more
        than 1. The default 10 is at 1.8 R under two dipoles, and far above the noise.
    margin_db : How far a reading may lie above the law of equivalent distance [dB]. Of the default
        16, 6 are for a reflection as strong as the direct path and 10 for noise and for antennas on
        a circle; a shadow entered beyond 2.5 R + a step is then seen.
    """

    threshold_w: float
    radius_m: float = 0.20
    arming_ratio: float = 10.0
    margin_db: float = 16.0

    def __post_init__(self) -> None:
        for name, unit, low in (
            ("threshold_w", "W", 0.0),
            ("radius_m", "m", 0.0),
            ("arming_ratio", "times the threshold", 1.0),
            ("margin_db", "dB", 0.0),
        ):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > low):
                msg = (
                    f"{name} is {value} {unit}, but it must be above {low:g} and finite: "
                    "give a value from a link with signal at the arrival radius."
                )
                raise NavigationError(msg)

    def equivalent_distance_m(self, spread_w: float) -> float:
        """Return the distance R (s/threshold)^(1/4) from the point under the tag [m].

        Exact near two dipoles' null, too short beyond about half the tag's height.

        Parameters
        ----------
        spread_w : Spread of the RSS [W].
        """
        return float(self.radius_m * (spread_w / self.threshold_w) ** (1.0 / _NULL_EXPONENT))


@dataclass(frozen=True, slots=True, kw_only=True)
class ArrivalState:
    """What the arrival test remembers of the current leg; the defaults begin one.

    Parameters
    ----------
    armed : The spread has been well above the threshold, and since then every fall was possible.
    least_distance_m : Least distance of the tag by the readings and the way driven since [m].
    anchor_m : Dead-reckoned place where the leg began or the last impossible fall was seen [m].
    driven_m : Distance driven since then [m].
    """

    armed: bool = False
    least_distance_m: float = 0.0
    anchor_m: tuple[float, float] = (0.0, 0.0)
    driven_m: float = 0.0


def observe_spread(
    test: ArrivalTest,
    state: ArrivalState,
    *,
    spread_w: float,
    driven_m: float,
    place_m: tuple[float, float],
) -> tuple[bool, ArrivalState]:
    """Return whether the robot has arrived, and what the test remembers from now on.

    Parameters
    ----------
    test : Threshold and margins of the current tag.
    state : What was remembered before this reading.
    spread_w : Spread of this reading [W]; zero, without any signal, is never an arrival.
    driven_m : Distance driven since the previous reading [m].
    place_m : Dead-reckoned place from where the leg began [m].
    """
    state = replace(
        state,
        least_distance_m=max(0.0, state.least_distance_m - driven_m),
        driven_m=state.driven_m + driven_m,
    )
    if not spread_w > 0.0:
        return False, state
    margin = 10.0 ** (test.margin_db / (10.0 * _NULL_EXPONENT))
    least_m = max(state.least_distance_m, test.equivalent_distance_m(spread_w) / margin)
    if spread_w > test.threshold_w:
        armed = state.armed or spread_w >= test.arming_ratio * test.threshold_w
        return False, replace(state, armed=armed, least_distance_m=least_m)
    if least_m > test.radius_m:
        return False, ArrivalState(least_distance_m=least_m, anchor_m=place_m)
    hovers = (
        state.driven_m >= _HOVER_DRIVEN_RADII * test.radius_m
        and math.dist(place_m, state.anchor_m) <= _HOVER_AWAY_RADII * test.radius_m
    )
    return state.armed or hovers, replace(state, least_distance_m=least_m)


def arrival_threshold_w(
    link: PowerLink, tag_point_m: npt.ArrayLike, *, radius_m: float, azimuths: int = 36
) -> float:
    """Return the mean of max z - min z over the directions, at the arrival radius [W].

    Parameters
    ----------
    link : The tag's link to the reader, in free space or in the room.
    tag_point_m : (2,) float64 — Point on the floor under the tag [m].
    radius_m : Arrival radius [m].
    azimuths : Number of directions from which the robot comes.
    """
    centre = frozen_array(tag_point_m, name="tag_point_m", shape=(2,), error=NavigationError)
    if not (np.isfinite(radius_m) and radius_m > 0.0 and azimuths > 0):
        msg = (
            f"radius_m is {radius_m} m and azimuths is {azimuths}, but both must be positive: "
            "0.20 m and 36 are usual."
        )
        raise NavigationError(msg)
    side = 2.0 * np.pi * np.arange(azimuths) / azimuths
    around = radius_m * np.column_stack([np.cos(side), np.sin(side)])
    poses = np.column_stack([centre + around, wrap_angle(side + np.pi)])
    threshold = float(rss_spread_w(link.rss_w(poses)).mean())
    if not threshold > 0.0:
        msg = (
            f"all antennas receive the same {radius_m} m from the point under the tag at "
            f"({centre[0]:g}, {centre[1]:g}) m, so arrival cannot be detected: check the reader's "
            "patterns and what stands in the way."
        )
        raise NavigationError(msg)
    return threshold


def arrival_tests(
    links: Mapping[str, PowerLink],
    tag_ids: Sequence[str],
    tag_points_m: npt.ArrayLike,
    *,
    radius_m: float = 0.20,
) -> tuple[ArrivalTest, ...]:
    """Return one arrival test for each tag of a mission, in order, from its link.

    Parameters
    ----------
    links : Link of each tag.
    tag_ids : Tags in the mission's order.
    tag_points_m : (k, 2) float64 — Points on the floor under them [m].
    radius_m : Arrival radius [m].
    """
    points = frozen_array(
        tag_points_m, name="tag_points_m", shape=(len(tag_ids), 2), error=NavigationError
    )
    tests = []
    for tag_id, point in zip(tag_ids, points, strict=True):
        if tag_id not in links:
            raise unknown_tag(tag_id, tuple(links))
        threshold_w = arrival_threshold_w(links[tag_id], point, radius_m=radius_m)
        tests.append(ArrivalTest(threshold_w=threshold_w, radius_m=radius_m))
    return tuple(tests)
