"""One drive of a robot in plain arrays, as files of other programs take it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.bodies import Body
from octant.geometries.errors import NavigationError
from octant.navigation.angles import wrap_angle
from octant.navigation.control.polar import pose_from_goal_frame, pose_in_goal_frame
from octant.navigation.sensing.bearing import turn_towards, vector_sum_bearing
from octant.reader_design.showing.rasters import Raster

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Surroundings:
    """What stands about a drive.

    Parameters
    ----------
    bodies : Walls and objects [m].
    floor : 1 where the floor is free, 0 where something stands, NaN outside; None: there is none.
    closing : Names of the bodies that close the room, which viewers see through.
    """

    bodies: tuple[Body, ...] = ()
    floor: Raster | None = None
    closing: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class Carrier:
    """The robot's body and the reader on it.

    Parameters
    ----------
    radius_m, height_m : Of the round body [m].
    reader_height_m : Ground plane of the reader above the floor [m].
    antenna_radius_m : Of the circle of the antennas [m].
    azimuths_rad : (a,) float64 — Of the antennas in the reader's frame, whose +y is the front
        [rad]; none: the robot carries no such reader.
    """

    radius_m: float
    height_m: float
    reader_height_m: float = 0.0
    antenna_radius_m: float = 0.0
    azimuths_rad: FloatArray = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveLog:
    """A drive, one row a sample; what a drive does not have is None.

    Parameters
    ----------
    name : In the files' metadata.
    time_s : (s,) float64 — Time [s], rising.
    poses : (s, 3) float64 — True x [m], y [m], heading [rad].
    carrier : The robot.
    floor_m : Height of the floor in the room's frame [m].
    belief : (s, 3) float64 or None — Where the robot believes to be [m], [rad]; NaN: it does not.
    odometry : (s, 3) float64 or None — Pose by the wheels alone since the start, in the axes of
        ``origin`` [m], [rad].
    origin : (3,) float64 — The robot's odometry starts here in the room [m], [rad].
    commands : (s, 2) float64 or None — Commanded speed [m/s] and turn rate [rad/s].
    rss_w : (s, a) float64 or None — Readings [W]; NaN: none was made; 0: nothing was received.
    targets : Tag that is read, one a sample; none: no tag in particular.
    states : What the robot does, one a sample.
    wanted : (k, 3) float64 or None — The way that it should take: x [m], y [m], heading [rad].
    tags_m : Places of the tags by their ids, (3,) [m].
    believed_tag_m : (s, 2) float64 or None — Where it believes the tag it reads [m]; NaN: nowhere.
    around : What stands about.
    facts : Further metadata, such as how the drive ended.
    """

    name: str
    time_s: FloatArray
    poses: FloatArray
    carrier: Carrier
    floor_m: float = 0.0
    belief: FloatArray | None = None
    odometry: FloatArray | None = None
    origin: FloatArray = field(default_factory=lambda: np.zeros(3))
    commands: FloatArray | None = None
    rss_w: FloatArray | None = None
    targets: tuple[str, ...] = ()
    states: tuple[str, ...] = ()
    wanted: FloatArray | None = None
    tags_m: Mapping[str, FloatArray] = field(default_factory=dict)
    believed_tag_m: FloatArray | None = None
    around: Surroundings = field(default_factory=Surroundings)
    facts: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        rows = len(self.time_s)
        for name, shape in (
            ("time_s", (rows,)),
            ("poses", (rows, 3)),
            ("belief", (rows, 3)),
            ("odometry", (rows, 3)),
            ("origin", (3,)),
            ("commands", (rows, 2)),
            ("rss_w", (rows, len(self.carrier.azimuths_rad))),
            ("wanted", (None, 3)),
            ("believed_tag_m", (rows, 2)),
        ):
            if getattr(self, name) is None:
                continue
            array = frozen_array(
                getattr(self, name),
                name=name,
                shape=shape,
                finite=name not in ("belief", "rss_w", "believed_tag_m"),
                error=NavigationError,
            )
            object.__setattr__(self, name, array)
        if rows < 1 or (np.diff(self.time_s) <= 0.0).any():
            msg = f"the drive {self.name!r} has {rows} samples; it needs one or more, times rising."
            raise NavigationError(msg)
        for name, texts in (("targets", self.targets), ("states", self.states)):
            if texts and len(texts) != rows:
                msg = f"{name} has {len(texts)} entries for {rows} samples; give one for each."
                raise NavigationError(msg)

    @property
    def bearing_rad(self) -> FloatArray | None:
        """Bearing by the vector sum of the readings against the front, (s,) [rad]; NaN: none."""
        if self.rss_w is None:
            return None
        heard = np.nan_to_num(self.rss_w, nan=0.0)
        bearing: FloatArray = turn_towards(vector_sum_bearing(heard, self.carrier.azimuths_rad))
        return bearing

    @property
    def true_bearing_rad(self) -> FloatArray | None:
        """True bearing of the tag that is read against the front, (s,) [rad]; None: no such tag."""
        if not self.targets:
            return None
        places = np.array([self.tags_m[tag][:2] for tag in self.targets])
        away = places - self.poses[:, :2]
        return wrap_angle(np.arctan2(away[:, 1], away[:, 0]) - self.poses[:, 2])

    @property
    def corrections(self) -> FloatArray:
        """Pose of odometry's axes in the room that puts the robot where it believes, (s, 3).

        Before a first belief they stand at ``origin``; without one the last correction holds.
        """
        found = np.tile(self.origin, (len(self.time_s), 1))
        if self.belief is None or self.odometry is None:
            return found
        back = pose_in_goal_frame(np.zeros(3), self.odometry)
        wanted = pose_from_goal_frame(back, self.belief)
        last = self.origin
        for k, correction in enumerate(wanted):
            if np.isfinite(correction).all():
                last = correction
            found[k] = last
        return found
