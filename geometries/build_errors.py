"""How a reader that was built differs from its drawing: places, lengths, angles."""

import math
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import GeometryError

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BuildErrors:
    """What was built less what was drawn; arrays hold one value for each antenna or plate.

    Plates stay plane, upright and joined at the axis and to the ground plane, which stays plane. A
    plate that ends on its rim ends there as built, too.

    Parameters
    ----------
    radial_m : (n,) float64 — Offset of each antenna away from the axis [m].
    azimuth_rad : (n,) float64 — Offset of each antenna's azimuth [rad]; the antenna turns with it.
    gap_m : (n,) float64 — Offset of each antenna's lower end's height [m]; monopoles: none.
    length_m : (n,) float64 — Offset of each antenna's length [m].
    tilt_rad : (n,) float64 — Angle to the vertical [rad], 0 to below pi/2; the lower end stays.
    tilt_azimuth_rad : (n,) float64 — Where each antenna leans [rad], seen from its own place: 0
        away from the axis, pi/2 towards greater azimuth.
    plate_azimuth_rad : (n,) float64 — Offset of each plate's azimuth [rad]; plate i stands between
        antennas i and i + 1.
    plate_height_m : (n,) float64 — Offset of each plate's height at its outer end [m]; at the axis
        their mean counts. A height of zero stays zero.
    ground_plane_m : Offset of the ground plane's side or diameter [m].
    """

    radial_m: FloatArray
    azimuth_rad: FloatArray
    gap_m: FloatArray
    length_m: FloatArray
    tilt_rad: FloatArray
    tilt_azimuth_rad: FloatArray
    plate_azimuth_rad: FloatArray
    plate_height_m: FloatArray
    ground_plane_m: float = 0.0

    def __post_init__(self) -> None:
        count = np.size(self.radial_m)
        for name in ARRAYS:
            value = frozen_array(getattr(self, name), name=name, shape=(count,))
            object.__setattr__(self, name, value)
        if not math.isfinite(self.ground_plane_m):
            msg = (
                f"ground_plane_m is {self.ground_plane_m} m, but an error must be a finite number."
            )
            raise GeometryError(msg)
        wrong = np.flatnonzero((self.tilt_rad < 0.0) | (self.tilt_rad >= 0.5 * math.pi))
        if wrong.size:
            msg = (
                f"tilt_rad of antenna {wrong[0] + 1} is {self.tilt_rad[wrong[0]]:.4g} rad, but it "
                "must be from 0 to less than pi/2; where it leans is tilt_azimuth_rad."
            )
            raise GeometryError(msg)

    @property
    def antennas(self) -> int:
        """Number of antennas."""
        return len(self.radial_m)

    @property
    def is_zero(self) -> bool:
        """Whether the reader is as drawn; where an upright antenna leans does not matter."""
        names = [name for name in ARRAYS if name != "tilt_azimuth_rad"]
        return self.ground_plane_m == 0.0 and not any(getattr(self, n).any() for n in names)

    @property
    def lean(self) -> FloatArray:
        """Tangent of the tilt, away from the axis and towards greater azimuth, (n, 2) [-]."""
        slope = np.tan(self.tilt_rad)
        lean: FloatArray = slope[:, None] * np.column_stack(
            (np.cos(self.tilt_azimuth_rad), np.sin(self.tilt_azimuth_rad))
        )
        return lean

    def plus(self, other: "BuildErrors") -> "BuildErrors":
        """Return both errors together, e.g. those of a batch and of one reader ([m], [rad]).

        Parameters
        ----------
        other : For as many antennas; its slopes add to these.
        """
        if other.antennas != self.antennas:
            msg = (
                f"errors of {self.antennas} and of {other.antennas} antennas were given to be "
                "added; give both for the same reader."
            )
            raise GeometryError(msg)
        lean = self.lean + other.lean
        sums = {name: getattr(self, name) + getattr(other, name) for name in ARRAYS}
        sums["tilt_rad"], sums["tilt_azimuth_rad"] = tilt_of_lean(lean)
        return BuildErrors(ground_plane_m=self.ground_plane_m + other.ground_plane_m, **sums)

    def as_dict(self) -> dict[str, list[float] | float]:
        """Return all errors by name as plain values, for content hashes ([m], [rad])."""
        lists: dict[str, list[float] | float] = {n: getattr(self, n).tolist() for n in ARRAYS}
        return {**lists, "ground_plane_m": self.ground_plane_m}


ARRAYS = tuple(f.name for f in fields(BuildErrors) if f.name != "ground_plane_m")
"""Names of the errors of single antennas and plates [-]."""


def common_errors(
    antennas: int,
    *,
    radial_m: float = 0.0,
    azimuth_rad: float = 0.0,
    gap_m: float = 0.0,
    length_m: float = 0.0,
    tilt_rad: float = 0.0,
    tilt_azimuth_rad: float = 0.0,
    plate_azimuth_rad: float = 0.0,
    plate_height_m: float = 0.0,
    ground_plane_m: float = 0.0,
) -> BuildErrors:
    """Return errors that all antennas and all plates share, as of a wrong jig ([m], [rad]).

    Parameters
    ----------
    antennas : Number of antennas.
    radial_m, gap_m, length_m : Offsets of r_a, of the gap and of the antennas' length [m].
    azimuth_rad, plate_azimuth_rad : Turn of all antennas, and of all plates [rad].
    tilt_rad, tilt_azimuth_rad : How much antennas lean, and where, each seen from its place [rad].
    plate_height_m : Offset of h_p [m].
    ground_plane_m : Offset of the ground plane's side or diameter [m].
    """
    return BuildErrors(
        radial_m=np.full(antennas, radial_m),
        azimuth_rad=np.full(antennas, azimuth_rad),
        gap_m=np.full(antennas, gap_m),
        length_m=np.full(antennas, length_m),
        tilt_rad=np.full(antennas, tilt_rad),
        tilt_azimuth_rad=np.full(antennas, tilt_azimuth_rad),
        plate_azimuth_rad=np.full(antennas, plate_azimuth_rad),
        plate_height_m=np.full(antennas, plate_height_m),
        ground_plane_m=ground_plane_m,
    )


def tilt_of_lean(lean: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return (n,) tilts and (n,) tilt azimuths of antennas that lean by given slopes [rad].

    Parameters
    ----------
    lean : (n, 2) — Tangent [-] of the tilt away from the axis and towards greater azimuth.
    """
    slope = np.asarray(lean, dtype=np.float64)
    return np.arctan(np.hypot(slope[:, 0], slope[:, 1])), np.arctan2(slope[:, 1], slope[:, 0])
