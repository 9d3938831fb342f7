"""The space of designs: survey points, and the box of parameters as the unit cube."""

import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from msgspec.structs import replace

from octant.reader_design.setting.tangents import PROFILE
from octant.reader_design.study_file.optimise import Optimise
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]

LENGTH_STEP_M = 1e-4
"""Lengths are searched in steps of this [m]: what a workshop keeps, and a design that comes up
again is not solved again."""
LOAD_STEP_OHM = 1.0
"""Loads are searched in steps of this [ohm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """The parameters that vary and their bounds, around a design that has all other values.

    Attributes
    ----------
    base : Values of everything that does not vary.
    names : (p,) — Parameters that vary.
    low, high : (p,) — Their bounds, in the unit of each name [m], [ohm].
    """

    base: Reader
    names: tuple[str, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    def design(self, point: npt.ArrayLike) -> Reader:
        """Return the design at a point of the unit cube, in steps that can be made.

        Parameters
        ----------
        point : (p,) array_like — Place between the bounds, 0 to 1, clipped [-].
        """
        share = np.clip(np.asarray(point, dtype=np.float64), 0.0, 1.0)
        values = {
            name: _stepped(name, low, low + float(s) * (high - low), high)
            for name, low, high, s in zip(self.names, self.low, self.high, share, strict=True)
        }
        return with_values(self.base, values)

    def point(self, design: Reader, *, frequency_hz: float) -> FloatArray:
        """Return where a design lies in the unit cube [-]; beyond a bound, on it.

        Parameters
        ----------
        design : Any design.
        frequency_hz : Frequency at which antennas without a length are resonant [Hz].
        """
        low, high = np.array(self.low), np.array(self.high)
        values = [key_value(design, name, frequency_hz) for name in self.names]
        share: FloatArray = np.clip((np.array(values) - low) / (high - low), 0.0, 1.0)
        return share


def profile_key(number: int) -> str:
    """Return the name of one height of the plates' profile, counted from the axis [-].

    Parameters
    ----------
    number : Which one, from 0.
    """
    return f"{PROFILE}.{number}"


def with_values(design: Reader, values: Mapping[str, float]) -> Reader:
    """Return a design with other values of keys, heights of the plates' profile among them.

    Parameters
    ----------
    design, values : The design; values by key [m], [ohm].
    """
    profile = list(design.plate_profile_m)
    for name in [name for name in values if name.startswith(f"{PROFILE}.")]:
        profile[int(name.rpartition(".")[2])] = values[name]
    changes: dict[str, Any] = {k: v for k, v in values.items() if not k.startswith(f"{PROFILE}.")}
    return replace(design, plate_profile_m=tuple(profile), **changes)


def _stepped(name: str, low: float, value: float, high: float) -> float:
    """Return a value on the grid of what can be made, within the bounds."""
    per_unit = 1.0 / (LOAD_STEP_OHM if name == "load_ohm" else LENGTH_STEP_M)
    return min(max(round(value * per_unit) / per_unit, low), high)


def key_value(design: Reader, name: str, frequency_hz: float) -> float:
    """Return a parameter of a design, defaults resolved [m], [ohm].

    Parameters
    ----------
    design, name : The design, and a key of ``[reader]`` that may vary.
    frequency_hz : Frequency at which antennas without a length are resonant [Hz].
    """
    if name.startswith(f"{PROFILE}."):
        return design.plate_profile_m[int(name.rpartition(".")[2])]
    if name == "antenna_length_m":
        return design.element(frequency_hz).length_m or 0.0
    value = getattr(design, name)
    if value is None:
        return design.plate_height_m if name == "plate_height_axis_m" else design.ground_plane_m / 2
    return float(value)


def boxes(study: Study, table: Optimise) -> tuple[Box, ...]:
    """Return the box of parameters for each combination of choices; the first varies slowest.

    Parameters
    ----------
    study : Its ``[reader]`` has the values of all that is neither parameter nor choice.
    table : Parameters and choices.
    """
    base, choices, given = study.reader, table.choices.given(), table.parameters.given()
    bounds: dict[str, tuple[float, float]] = {}
    for name, pair in given.items():
        heights = map(profile_key, range(len(base.plate_profile_m)))
        bounds |= dict.fromkeys(heights, pair) if name == PROFILE else {name: pair}
    combinations: list[dict[str, Any]] = [
        dict(zip(choices, values, strict=True)) for values in itertools.product(*choices.values())
    ]
    return tuple(
        Box(
            base=replace(base, **combination),
            names=tuple(bounds),
            low=tuple(low for low, _ in bounds.values()),
            high=tuple(high for _, high in bounds.values()),
        )
        for combination in combinations
    )


def survey_designs(
    box: Box, count: int, *, frequency_hz: float, generator: np.random.Generator
) -> tuple[Reader, ...]:
    """Return designs spread over a box, none twice: its base, then a scrambled Halton sequence.

    Parameters
    ----------
    box : Parameters and bounds; without parameters it has its base only.
    count : How many besides the base.
    frequency_hz : Frequency at which antennas without a length are resonant [Hz].
    generator : Scrambles the sequence.
    """
    from scipy.stats import qmc

    if not box.names:
        return (box.base,)
    points = [box.point(box.base, frequency_hz=frequency_hz)]
    points += list(qmc.Halton(len(box.names), rng=generator).random(count))
    return tuple(dict.fromkeys(box.design(point) for point in points))
