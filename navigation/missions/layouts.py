"""The thesis' mission: its four tags and its start."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.missions.records import Mission
from octant.navigation.navigators.arrival import ArrivalTest


@dataclass(frozen=True, slots=True, kw_only=True)
class TagPlace:
    """Return a tag and where it hangs.

    Parameters
    ----------
    tag_id : str
        Its ID.
    position_m : (3,) float64
        Its place in the room [m].

    Raises
    ------
    NavigationError
        When the place is not three finite numbers.
    """

    tag_id: str
    position_m: npt.NDArray[np.float64]

    def __post_init__(self) -> None:
        position = frozen_array(
            self.position_m,
            name=f"position_m of tag {self.tag_id!r}",
            shape=(3,),
            error=NavigationError,
        )
        object.__setattr__(self, "position_m", position)

    @property
    def point_m(self) -> npt.NDArray[np.float64]:
        """Return the (2,) point on the floor under the tag [m]."""
        return self.position_m[:2]


THESIS_START_M = (0.0, 0.0)
"""Start of the thesis' mission [m]."""

THESIS_HEADING_RAD = float(np.pi / 2.0)
"""Heading at its start [rad]."""


def thesis_tags() -> tuple[TagPlace, ...]:
    """Return the four tags of the thesis' mission in the order of the visit.

    Returns
    -------
    tuple of TagPlace
        Tags on the ceiling at 3 m (thesis 5.4) [m]. The thesis prints the IDs with five hexadecimal
        digits, which are 20 bit, and calls them 16-bit; one F too many is dropped here.
    """
    places = (
        ("0xFFF9", (2.0, 0.5, 3.0)),
        ("0xFFF2", (3.5, 2.0, 3.0)),
        ("0xFFF5", (2.0, 3.5, 3.0)),
        ("0xFFF4", (4.0, 3.5, 3.0)),
    )
    return tuple(TagPlace(tag_id=tag_id, position_m=np.array(place)) for tag_id, place in places)


def thesis_mission(arrivals: tuple[ArrivalTest, ...], *, cruise_step_m: float = 0.09) -> Mission:
    """Return the mission of thesis 5.4.

    Parameters
    ----------
    arrivals : tuple of ArrivalTest
        One for each of `thesis_tags`; `arrival.arrival_tests` makes them.
    cruise_step_m : float
        Distance driven straight ahead in one period of 1 s [m]; the thesis does not state it.

    Returns
    -------
    Mission
        Start (0, 0) m, heading 90°, four tags, T = 1 s.

    Raises
    ------
    NavigationError
        When there are not four arrival tests.
    """
    tags = thesis_tags()
    return Mission(
        start_m=np.array(THESIS_START_M),
        heading_rad=THESIS_HEADING_RAD,
        tag_ids=tuple(tag.tag_id for tag in tags),
        tag_points_m=np.array([tag.point_m for tag in tags]),
        arrivals=arrivals,
        sample_time_s=1.0,
        cruise_step_m=cruise_step_m,
    )
