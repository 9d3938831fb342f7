"""A camera with depth that detects a landmark: where it looks, what hides it, and its errors."""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.geometries.occlusion import segments_blocked
from octant.geometries.scene import Scene
from octant.geometries.tolerances import LENGTHS
from octant.navigation.angles import wrap_angle
from octant.navigation.checks import check_positive

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Landmark:
    """A landmark with a frame of its own.

    Parameters
    ----------
    position_m : (3,) float64 — Place in the room [m].
    heading_rad : Direction of a robot that faces the landmark squarely, into it [rad].
    """

    position_m: FloatArray
    heading_rad: float

    def __post_init__(self) -> None:
        place = frozen_array(
            self.position_m, name="position_m of the landmark", shape=(3,), error=NavigationError
        )
        object.__setattr__(self, "position_m", place)
        if not np.isfinite(self.heading_rad):
            msg = f"heading_rad is {self.heading_rad} rad, but it must be finite: give an angle."
            raise NavigationError(msg)

    def goal(self, stand_off_m: float) -> FloatArray:
        """Return the pose in front of the landmark, facing it: x [m], y [m], heading [rad].

        Parameters
        ----------
        stand_off_m : Distance from the landmark [m].
        """
        ahead = np.array([np.cos(self.heading_rad), np.sin(self.heading_rad)])
        return np.array([*(self.position_m[:2] - stand_off_m * ahead), self.heading_rad])

    def in_body(self, poses: npt.ArrayLike) -> FloatArray:
        """Return e_x, e_y [m], ψ in (-π, π] [rad] seen from robots, (13) of the docking paper.

        Parameters
        ----------
        poses : (..., 3) array_like — x [m], y [m], heading [rad] of the robot in the room.
        """
        pose = np.asarray(poses, dtype=np.float64)
        dx, dy = self.position_m[0] - pose[..., 0], self.position_m[1] - pose[..., 1]
        cos, sin = np.cos(pose[..., 2]), np.sin(pose[..., 2])
        psi = wrap_angle(self.heading_rad - pose[..., 2])
        return np.stack([cos * dx + sin * dy, cos * dy - sin * dx, psi], axis=-1)

    def check(self, scene: Scene) -> None:
        """Refuse a landmark that no camera in the room can see.

        Parameters
        ----------
        scene : Room and objects.
        """
        front = np.array(self.position_m)
        front[:2] -= LENGTHS.step_m * np.array([np.cos(self.heading_rad), np.sin(self.heading_rad)])
        buried = bool(scene.inside_solid(front[None])[0])
        if buried or not scene.inside_room(front[None])[0]:
            what = "inside an object" if buried else "inside a wall or outside the room"
            place = ", ".join(f"{c:g}" for c in self.position_m)
            msg = (
                f"the landmark at ({place}) m, faced at {np.degrees(self.heading_rad):g} degrees, "
                f"is {what}, but its front must be in free space: move it or turn it."
            )
            raise NavigationError(msg)


@dataclass(frozen=True, slots=True, kw_only=True)
class LandmarkSensor:
    """An RGB-D camera with its landmark detector; the defaults are the paper's camera pose.

    Docking paper VII: p_C = (0.090, 0.03, 0.775) m, yaw 0.216 rad, R = 0.01 for each coordinate and
    for the attitude. Field of view and range, not stated there, are the first Kinect's.

    Parameters
    ----------
    position_m : (3,) float64 — Camera ahead of the axle, to the left, above the floor [m].
    yaw_rad : Direction of its optical axis in the body frame [rad].
    width_rad, height_rad : Field of view, horizontal and vertical, about the horizontal [rad].
    nearest_m, farthest_m : Distances between which the landmark is recognised [m].
    obliqueness_rad : Greatest angle between the line of sight and the landmark's normal [rad].
    position_sd_m, attitude_sd_rad : Standard deviations of what is measured [m], [rad].
    detection_probability : Probability that a landmark in sight is detected [-].
    false_probability : Probability that something else is reported in its stead [-].
    scene : What can hide the landmark; None: nothing.
    """

    position_m: FloatArray = field(default_factory=lambda: np.array([0.090, 0.03, 0.775]))
    yaw_rad: float = 0.216
    width_rad: float = float(np.radians(57.0))
    height_rad: float = float(np.radians(43.0))
    nearest_m: float = 0.4
    farthest_m: float = 4.5
    obliqueness_rad: float = float(np.radians(70.0))
    position_sd_m: float = 0.1
    attitude_sd_rad: float = 0.1
    detection_probability: float = 1.0
    false_probability: float = 0.0
    scene: Scene | None = None

    def __post_init__(self) -> None:
        place = frozen_array(
            self.position_m, name="position_m of the camera", shape=(3,), error=NavigationError
        )
        object.__setattr__(self, "position_m", place)
        for name, unit in (
            ("width_rad", "rad"),
            ("height_rad", "rad"),
            ("nearest_m", "m"),
            ("farthest_m", "m"),
            ("obliqueness_rad", "rad"),
        ):
            check_positive(getattr(self, name), name=name, unit=unit)
        for name, unit in (("position_sd_m", "m"), ("attitude_sd_rad", "rad")):
            check_positive(getattr(self, name), name=name, unit=unit, allow_zero=True)
        for name in ("detection_probability", "false_probability"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                msg = f"{name} is {getattr(self, name)}, but it must lie in [0, 1]: correct it."
                raise NavigationError(msg)

    def in_sight(self, poses: npt.ArrayLike, landmark: Landmark) -> npt.NDArray[np.bool_]:
        """Return from which poses the camera sees the landmark, (n,).

        In the field of view, in range, not too oblique and not hidden by the scene's mesh.

        Parameters
        ----------
        poses : (n, 3) array_like — x [m], y [m], heading [rad] of the robot in the room.
        landmark : What to look for.
        """
        pose = np.asarray(poses, dtype=np.float64).reshape(-1, 3)
        cos, sin = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        eye = np.empty((len(pose), 3))
        eye[:, 0] = pose[:, 0] + cos * self.position_m[0] - sin * self.position_m[1]
        eye[:, 1] = pose[:, 1] + sin * self.position_m[0] + cos * self.position_m[1]
        floor_m = 0.0 if self.scene is None else self.scene.floor_height_m
        eye[:, 2] = floor_m + self.position_m[2]
        ray = landmark.position_m - eye
        flat = np.hypot(ray[:, 0], ray[:, 1])
        distance = np.hypot(flat, ray[:, 2])
        azimuth = np.arctan2(ray[:, 1], ray[:, 0])
        off_axis = np.abs(wrap_angle(azimuth - pose[:, 2] - self.yaw_rad))
        elevation = np.abs(np.arctan2(ray[:, 2], flat))
        oblique = np.abs(wrap_angle(azimuth - landmark.heading_rad))
        seen = (
            (off_axis <= 0.5 * self.width_rad)
            & (elevation <= 0.5 * self.height_rad)
            & (distance >= self.nearest_m)
            & (distance <= self.farthest_m)
            & (oblique <= self.obliqueness_rad)
        )
        if self.scene is not None and self.scene.bodies and seen.any():
            chosen = np.flatnonzero(seen)
            ends = np.tile(landmark.position_m, (len(chosen), 1))
            ends -= LENGTHS.step_m * ray[chosen] / distance[chosen, None]
            seen[chosen] = ~segments_blocked(self.scene.bvh, eye[chosen], ends)
        return np.asarray(seen)

    def detect(
        self, poses: npt.ArrayLike, landmark: Landmark, rng: np.random.Generator
    ) -> FloatArray:
        """Return the measured e_x, e_y [m], ψ [rad] in the body frame, (n, 3); NaN for no report.

        Parameters
        ----------
        poses, landmark : As for `in_sight` [m, rad].
        rng : Source of the errors; the same number of draws for every pose.
        """
        pose = np.asarray(poses, dtype=np.float64).reshape(-1, 3)
        n = len(pose)
        chance, normal = rng.random((n, 5)), rng.standard_normal((n, 3))
        sd = np.array([self.position_sd_m, self.position_sd_m, self.attitude_sd_rad])
        measured = landmark.in_body(pose) + sd * normal
        detected = self.in_sight(pose, landmark) & (chance[:, 0] < self.detection_probability)
        wrong = chance[:, 1] < self.false_probability
        measured[~detected] = np.nan
        measured[wrong] = self._clutter(chance[wrong, 2:])
        measured[:, 2] = wrap_angle(measured[:, 2])
        return measured

    def _clutter(self, chance: FloatArray) -> FloatArray:
        """Return false landmarks, uniform over the field of view's area and over attitude."""
        near, far = self.nearest_m, self.farthest_m
        distance = np.sqrt(near**2 + (far**2 - near**2) * chance[:, 0])
        azimuth = self.yaw_rad + self.width_rad * (chance[:, 1] - 0.5)
        return np.column_stack(
            [
                self.position_m[0] + distance * np.cos(azimuth),
                self.position_m[1] + distance * np.sin(azimuth),
                2.0 * np.pi * (chance[:, 2] - 0.5),
            ]
        )
