"""The names of what a calibration fits, and the parameters that they stand for."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from octant.em.constants import VACUUM_PERMITTIVITY_F_PER_M
from octant.em.medium.materials import Material
from octant.geometries.errors import ConfigError
from octant.geometries.names import nearest_name
from octant.reader_design.experiments.measured.predict import Rows
from octant.reader_design.setting.setting import Setting
from octant.reader_design.study_file.calibration import Calibration
from octant.reader_design.study_file.materials import material_label, material_specs

FloatArray = npt.NDArray[np.float64]

Kind = Literal[
    "level",
    "diffuse",
    "antenna_level",
    "eps_r",
    "sigma",
    "thickness",
    "tilt",
    "place",
    "height",
]
OWN: tuple[Kind, ...] = ("level", "diffuse", "tilt", "place")
"""Kinds that belong to one tag or anchor each; all others are shared."""
_OF_MATERIALS = ("eps_r", "sigma", "thickness")
_AXES = ("x", "y", "z")
REACH_M, OFF_WALL_M = 0.5, 0.03
"""How far a place may move from the study's, and how near to the room's hull [m]."""
UNKNOWN_STEPS = 10.0
"""Doubt, in a parameter's natural steps, from which the log does not tell it [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Parameter:
    """One number that is fitted.

    Parameters
    ----------
    name : What it is called, such as ``sigma:walls`` or ``place:3.x``.
    kind, item : What it is; of which tag (its id), material (its label), antenna ("1" ...) or axis.
    axis : Which of several numbers of an item: x, y, z.
    unit : Unit of its value.
    start : Value of the study, in the unit; NaN: none, so that a fit finds its own [any].
    low, high : Bounds, in the unit.
    step : What counts as a large change: dB, m, deg, or of logarithmic ones the share [-]; scales
        the question whether the log tells it.
    logarithmic : Whether its logarithm is fitted: it is positive and known by its factor.
    """

    name: str
    kind: Kind
    item: str = ""
    axis: str = ""
    unit: str
    start: float
    low: float
    high: float
    step: float
    logarithmic: bool = False

    @property
    def own(self) -> bool:
        """Whether it belongs to one tag alone."""
        return self.kind in OWN

    def inward(self, value: float) -> float:
        """Return the fit's coordinate of a value.

        Parameters
        ----------
        value : In the parameter's unit [any].
        """
        return float(np.log(value)) if self.logarithmic else value

    def outward(self, coordinate: float) -> float:
        """Return the value of a fit's coordinate, in the parameter's unit.

        Parameters
        ----------
        coordinate : Of the fit [any].
        """
        return float(np.exp(coordinate)) if self.logarithmic else coordinate


def parameters_of(names: Sequence[str], setting: Setting, rows: Rows) -> tuple[Parameter, ...]:
    """Return the parameters that names stand for; refuse unknown and doubled ones.

    Parameters
    ----------
    names : Such as ``level``, ``sigma:walls``, ``tilt:3``; see `octant calibrate`.
    setting, rows : The room and its tags; the readings.
    """
    found: list[Parameter] = []
    for text in names:
        kind, _, item = text.strip().partition(":")
        found += _parameters(kind, item, text, setting, rows)
    doubled = [p.name for i, p in enumerate(found) if p.name in {q.name for q in found[:i]}]
    if doubled:
        msg = f"--fit names {doubled[0]!r} twice; name each value once."
        raise ConfigError(msg)
    if not found:
        msg = f"--fit names nothing; name what to fit: {', '.join(_FORMS)}."
        raise ConfigError(msg)
    return tuple(found)


_FORMS = (
    "level",
    "diffuse",
    "antenna_level",
    "eps_r:MATERIAL",
    "sigma:MATERIAL",
    "thickness:MATERIAL",
    "tilt:TAG",
    "place:TAG",
    "height",
)


def _parameters(kind: str, item: str, text: str, setting: Setting, rows: Rows) -> list[Parameter]:
    if kind in _OF_MATERIALS:
        return [_of_material(kind, item, text, setting)]
    if kind in {"level", "diffuse", "tilt", "place"}:
        heard = [rows.log.ids[s] for s in np.unique(rows.log.sources)]
        if item and item not in heard:
            near = nearest_name(item, heard) or ", ".join(heard)
            msg = f"--fit {text}: the log has no readings of a tag {item!r}; did you mean {near!r}?"
            raise ConfigError(msg)
        return [p for one in ([item] if item else heard) for p in _of_tag(kind, one, setting)]
    if kind == "antenna_level" and not item:
        return _of_antennas(setting, rows)
    if kind == "height" and not item:
        start = setting.reader.height_m
        top = float(np.ptp(setting.scene.bounds_m[:, 2])) if setting.has_room else start + 1.0
        return [
            Parameter(
                name="height",
                kind="height",
                unit="m",
                start=start,
                low=max(0.01, start - 0.5),
                high=min(start + 0.5, max(top - 0.01, start)),
                step=0.1,
            )
        ]
    known = [form.partition(":")[0] for form in _FORMS]
    like = nearest_name(kind, known, least_likeness=0.5)
    hint = f"did you mean {like!r}? " if like else ""
    msg = f"--fit {text} is unknown; {hint}It takes {', '.join(_FORMS)}."
    raise ConfigError(msg)


def _of_tag(kind: str, tag_id: str, setting: Setting) -> list[Parameter]:
    given = setting.study.calibration or Calibration()
    if kind == "level":
        start = given.level_db.get(tag_id, 0.0)
        return [
            Parameter(
                name=f"level:{tag_id}",
                kind="level",
                item=tag_id,
                unit="dB",
                start=start,
                low=-200.0,
                high=200.0,
                step=3.0,
            )
        ]
    if kind == "diffuse":
        start = given.diffuse_db.get(tag_id, math.nan)
        return [
            Parameter(
                name=f"diffuse:{tag_id}",
                kind="diffuse",
                item=tag_id,
                unit="dB",
                start=start,
                low=-150.0,
                high=0.0,
                step=3.0,
            )
        ]
    tag = setting.tag(tag_id)
    if kind == "tilt":
        return [
            Parameter(
                name=f"tilt:{tag_id}.{axis}",
                kind="tilt",
                item=tag_id,
                axis=axis,
                unit="deg",
                start=0.0,
                low=-80.0,
                high=80.0,
                step=10.0,
            )
            for axis in _AXES[:2]
        ]
    here = tag.position_m.tolist()
    low, high = (setting.scene.bounds_m + np.array([[OFF_WALL_M], [-OFF_WALL_M]])).tolist()
    if not setting.has_room:
        low, high = [-math.inf] * 3, [math.inf] * 3
    return [
        Parameter(
            name=f"place:{tag_id}.{axis}",
            kind="place",
            item=tag_id,
            axis=axis,
            unit="m",
            start=here[i],
            low=min(max(here[i] - REACH_M, low[i]), here[i] - 1e-6),
            high=max(min(here[i] + REACH_M, high[i]), here[i] + 1e-6),
            step=0.1,
        )
        for i, axis in enumerate(_AXES)
    ]


def _of_antennas(setting: Setting, rows: Rows) -> list[Parameter]:
    numbers = [int(a) for a in np.unique(rows.log.antennas)]
    if len(numbers) < 2:
        msg = (
            "--fit antenna_level compares the robot's antennas with the first, but the log has "
            f"readings of {len(numbers)}; fit level instead."
        )
        raise ConfigError(msg)
    given = (setting.study.calibration or Calibration()).antenna_db
    return [
        Parameter(
            name=f"antenna_level:{n}",
            kind="antenna_level",
            item=str(n),
            unit="dB",
            start=given[n - 1] if n <= len(given) else 0.0,
            low=-100.0,
            high=100.0,
            step=3.0,
        )
        for n in numbers[1:]
    ]


def material_paths(setting: Setting) -> dict[str, tuple[str, ...]]:
    """Return the key paths in the study of each material label of the scene.

    Parameters
    ----------
    setting : The room.
    """
    out: dict[str, list[str]] = {}
    for path, spec in material_specs(setting.study):
        if not path.startswith("layout"):
            out.setdefault(material_label(spec), []).append(path)
    return {k: tuple(v) for k, v in out.items() if k in setting.scene.material_names}


def scene_material(label: str, setting: Setting) -> Material:
    """Return what a label of the scene means at the study's first frequency, flat over it.

    Parameters
    ----------
    label, setting : One of ``scene.material_names``; the room.
    """
    radio = setting.radios[0]
    given = radio.materials[radio.scene.material_names.index(label)]
    eps = given.relative_permittivity(radio.frequency_hz)
    omega = 2.0 * np.pi * radio.frequency_hz
    return Material(
        name=given.name,
        eps_r_a=eps.real,
        sigma_c_s_per_m=-eps.imag * omega * VACUUM_PERMITTIVITY_F_PER_M,
        thickness_m=given.thickness_m,
    )


def _of_material(kind: str, item: str, text: str, setting: Setting) -> Parameter:
    paths = material_paths(setting)
    names = {label: label for label in paths}
    for label, where in paths.items():
        for path in where:
            names |= {path: label, path.rpartition(".")[2]: label}
    for i, body in enumerate(setting.study.room.objects):
        label = next((k for k, v in paths.items() if f"room.object[{i}].material" in v), "")
        if body.name and label:
            names[body.name] = label
    if item not in names:
        near = nearest_name(item, names) or ", ".join(names)
        msg = f"--fit {text}: the room has no material {item!r}; did you mean {near!r}?"
        raise ConfigError(msg)
    label = names[item]
    given = setting.radios[0].materials[setting.scene.material_names.index(label)]
    if given.is_pec or given.layers:
        what = "a perfect conductor" if given.is_pec else "in layers"
        msg = f"--fit {text}: material {label!r} is {what}; fit one that is a single medium."
        raise ConfigError(msg)
    here = scene_material(label, setting)
    if kind == "thickness" and here.thickness_m is None:
        msg = (
            f"--fit {text}: material {label!r} fills all behind its face; give it a thickness_m "
            "in the study first."
        )
        raise ConfigError(msg)
    value, unit, low, high, step = {
        "eps_r": (here.eps_r_a, "-", 1.0001, 80.0, 0.5),
        "sigma": (max(here.sigma_c_s_per_m, 1e-3), "S/m", 1e-4, 100.0, 1.0),
        "thickness": (here.thickness_m or 0.0, "m", 1e-3, 1.0, 0.5),
    }[kind]
    return Parameter(
        name=f"{kind}:{item}",
        kind=kind,  # type: ignore[arg-type]
        item=label,
        unit=unit,
        start=min(max(value, low), high),
        low=low,
        high=high,
        step=step,
        logarithmic=True,
    )
