"""What a calibration compares: levels predicted for values of its parameters, and their slopes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.decibels import decibels
from octant.em.medium.materials import Material
from octant.reader_design.experiments.measured.calibrate_names import Parameter, scene_material
from octant.reader_design.experiments.measured.observations import Observations
from octant.reader_design.experiments.measured.predict import (
    DBM_PER_W,
    Predictor,
    Values,
)
from octant.reader_design.study_file.calibration import Calibration

FloatArray = npt.NDArray[np.float64]

_STEPS = {"eps_r": 2e-3, "sigma": 5e-3, "thickness": 1e-3, "tilt": 0.05}
"""Differences that give slopes where paths stay: of logarithms of materials, of angles [deg]."""
_MOVED_M = 0.02
"""Half of the difference where paths are traced anew, some of which come and go [m]."""
_SILENT_DBM = -300.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LevelModel:
    """Predicts local means from the values of parameters, with slopes.

    Parameters
    ----------
    predictor, observations : Traced paths; the local means.
    parameters : What is fitted, in order.
    power_w : What each tag sends [W].
    """

    predictor: Predictor
    observations: Observations
    parameters: tuple[Parameter, ...]
    power_w: float

    def values(self, theta: FloatArray) -> Values:
        """Return the room and the tags at the fit's coordinates.

        Parameters
        ----------
        theta : (p,) float64 — Coordinates: logarithms of logarithmic parameters [any].
        """
        setting = self.predictor.setting
        materials: dict[str, Material] = {}
        tilts: dict[int, dict[str, float]] = {}
        places: dict[int, dict[str, float]] = {}
        height = None
        for p, coordinate in zip(self.parameters, theta, strict=True):
            value = p.outward(float(coordinate))
            if p.kind in {"eps_r", "sigma", "thickness"}:
                given = materials.get(p.item) or scene_material(p.item, setting)
                key = {
                    "eps_r": "eps_r_a",
                    "sigma": "sigma_c_s_per_m",
                    "thickness": "thickness_m",
                }[p.kind]
                materials[p.item] = replace(given, **{key: value})  # type: ignore[arg-type]
            elif p.kind in {"tilt", "place"}:
                number = [tag.id for tag in setting.tags].index(p.item)
                (tilts if p.kind == "tilt" else places).setdefault(number, {})[p.axis] = value
            elif p.kind == "height":
                height = value
        return Values(
            materials=materials,
            axes={n: self._axis(n, turned) for n, turned in tilts.items()},
            places_m={n: self._place(n, moved) for n, moved in places.items()},
            height_m=height,
        )

    def _axis(self, number: int, turned: dict[str, float]) -> tuple[float, float, float]:
        """Return a tag's axis after small turns about the room's x and then y axis."""
        axis = self.predictor.setting.tags[number].antennas[0].axis
        return tilted(axis, turned.get("x", 0.0), turned.get("y", 0.0))

    def _place(self, number: int, moved: dict[str, float]) -> tuple[float, float, float]:
        x, y, z = self.predictor.setting.tags[number].position_m.tolist()
        return moved.get("x", x), moved.get("y", y), moved.get("z", z)

    def _own(self, theta: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return level and diffuse gain of each source, and level of each antenna."""
        ids = self.predictor.rows.log.ids
        given = self.predictor.setting.study.calibration or Calibration()
        level = {name: given.level_db.get(name, 0.0) for name in ids}
        diffuse = {name: given.diffuse_db.get(name, -math.inf) for name in ids}
        antenna = np.zeros(self.predictor.antennas)
        stated = np.array(given.antenna_db, dtype=np.float64)[: len(antenna)]
        antenna[: len(stated)] = stated
        for p, value in zip(self.parameters, theta, strict=True):
            if p.kind == "level":
                level[p.item] = float(value)
            elif p.kind == "diffuse":
                diffuse[p.item] = float(value)
            elif p.kind == "antenna_level":
                antenna[int(p.item) - 1] = float(value)
        floor = 10.0 ** (0.1 * np.array([diffuse[name] for name in ids]))
        return np.array([level[name] for name in ids]), floor, antenna

    def readings_dbm(self, theta: FloatArray) -> FloatArray:
        """Return the predicted level of each reading, (n,) [dBm].

        Parameters
        ----------
        theta : (p,) float64 — As in `values` [any].
        """
        return self._levels(theta, self.predictor.gains(self.values(theta)))[0]

    def _levels(self, theta: FloatArray, gains: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return predicted levels of all readings, and the share of the diffuse field in each."""
        rows = self.predictor.rows
        level, floor, antenna = self._own(theta)
        source, column = rows.log.sources, np.maximum(rows.log.antennas - 1, 0)
        power = gains[source, rows.group, column] + floor[source]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(power > 0.0, floor[source] / power, 0.0)
        dbm = decibels(self.power_w * power) + DBM_PER_W + level[source] + antenna[column]
        return np.maximum(dbm, _SILENT_DBM), share

    def local_means(self, theta: FloatArray) -> FloatArray:
        """Return the predicted local mean of each observation, (o,) [dBm].

        Parameters
        ----------
        theta : (p,) float64 — As in `values` [any].
        """
        return self.observations.means(self.readings_dbm(theta))

    def slopes(self, theta: FloatArray, wanted: Sequence[int]) -> FloatArray:
        """Return the slopes of the local means, (o, len(wanted)) [dB per coordinate].

        Those of levels and diffuse fields are exact, the others central differences.

        Parameters
        ----------
        theta, wanted : (p,), and the numbers of the parameters that are asked for [any].
        """
        rows, ids = self.predictor.rows, self.predictor.rows.log.ids
        _, share = self._levels(theta, self.predictor.gains(self.values(theta)))
        columns = []
        for k in wanted:
            p = self.parameters[k]
            if p.kind in {"level", "diffuse"}:
                mine = rows.log.sources == ids.index(p.item)
                columns.append(np.where(mine, 1.0 if p.kind == "level" else share, 0.0))
            elif p.kind == "antenna_level":
                columns.append((rows.log.antennas == int(p.item)).astype(np.float64))
            else:
                columns.append(self._difference(theta, k))
        if not columns:
            return np.zeros((len(self.observations), 0))
        return self.observations.means(np.column_stack(columns))

    def _difference(self, theta: FloatArray, k: int) -> FloatArray:
        """Return the slope of each reading: one-sided where it is smooth, else over both sides."""
        p = self.parameters[k]
        low, high = (p.inward(bound) for bound in (p.low, p.high))
        step = _STEPS.get(p.kind)
        if step is None:
            ends = np.clip([theta[k] - _MOVED_M, theta[k] + _MOVED_M], low, high)
        else:
            ends = np.array([theta[k], theta[k] + (step if theta[k] + step < high else -step)])
        sides = []
        for end in ends:
            moved = theta.copy()
            moved[k] = end
            sides.append(self.readings_dbm(moved))
        slope: FloatArray = (sides[1] - sides[0]) / float(ends[1] - ends[0])
        return slope


def tilted(axis: npt.ArrayLike, x_deg: float, y_deg: float) -> tuple[float, float, float]:
    """Return an axis after turns about the room's x axis and then about its y axis.

    Parameters
    ----------
    axis : (3,) array_like — Direction before [-].
    x_deg, y_deg : Turns, right-handed [deg].
    """
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_euler("xy", [x_deg, y_deg], degrees=True).as_matrix()
    turned = turn @ np.asarray(axis, dtype=np.float64)
    return float(turned[0]), float(turned[1]), float(turned[2])
