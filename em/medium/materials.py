"""Building materials after ITU-R P.2040, perfect conductors, layered walls, and one's own."""

import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from octant.em.constants import VACUUM_PERMITTIVITY_F_PER_M
from octant.geometries.errors import MaterialRangeError, PhysicsWarning
from octant.geometries.material_names import known_as
from octant.geometries.names import nearest_name

EXTRAPOLATION = 2.5
"""Factor [-] by which a model is used beyond the frequencies that it was fitted to.

P.2040 calls its limits indicative of the measurements, not hard. The factor brings the RFID bands
at 433, 868 and 915 MHz within reach of what was fitted from 1 GHz on; beyond it a model is refused.
"""


LOWEST_RFID_HZ = 0.4e9
"""Frequency [Hz] from which every material is known somehow: below UHF RFID at 433 MHz."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Material:
    """Electrical properties of a wall: relative permittivity a f^b, conductivity c f^d, f in GHz.

    After ITU-R P.2040-4 (2025), equations 57, 58 and Table 3.

    Parameters
    ----------
    name : Name in the table, ``"pec"``, or one that describes a material of one's own.
    eps_r_a, eps_r_b : Relative permittivity a f^b [-].
    sigma_c_s_per_m, sigma_d : Conductivity c f^d [S/m].
    frequency_range_hz : Frequencies [Hz] for which the model was fitted; up to a factor of
        `EXTRAPOLATION` beyond them it is extrapolated with a PhysicsWarning.
    extrapolated_from_hz : Lowest frequency [Hz] of that, where it is another.
    thickness_m : Thickness [m] of a finite slab; None for a half-space.
    is_pec : Whether it is a perfect conductor; the numbers above then do not count.
    layers : Two or more layers of a wall, from the front, which the mesh's normal points to; the
        last may fill all that lies behind; the numbers above do not count. Empty: one material.
    """

    name: str
    eps_r_a: float = 1.0
    eps_r_b: float = 0.0
    sigma_c_s_per_m: float = 0.0
    sigma_d: float = 0.0
    frequency_range_hz: tuple[float, float] = (0.0, math.inf)
    extrapolated_from_hz: float | None = None
    thickness_m: float | None = None
    is_pec: bool = False
    layers: tuple["Material", ...] = ()

    def __post_init__(self) -> None:
        numbers = (self.eps_r_a, self.eps_r_b, self.sigma_c_s_per_m, self.sigma_d)
        if not all(math.isfinite(x) for x in numbers):
            msg = f"material {self.name!r} has a property that is not finite; give finite numbers."
            raise MaterialRangeError(msg)
        if self.eps_r_a < 1.0:
            msg = f"material {self.name!r} has eps_r = {self.eps_r_a}, but at least 1 is needed."
            raise MaterialRangeError(msg)
        if self.sigma_c_s_per_m < 0.0:
            msg = (
                f"material {self.name!r} has sigma = {self.sigma_c_s_per_m} S/m, but a passive "
                "wall needs at least 0."
            )
            raise MaterialRangeError(msg)
        if self.thickness_m is not None and not 0.0 < self.thickness_m < math.inf:
            msg = (
                f"material {self.name!r} has thickness_m = {self.thickness_m}, but a slab needs a "
                "thickness above 0 m; leave it out for a half-space."
            )
            raise MaterialRangeError(msg)
        if self.layers:
            self._check_layers()

    def _check_layers(self) -> None:
        if len(self.layers) == 1 or self.thickness_m is not None:
            msg = (
                f"material {self.name!r} has {len(self.layers)} layer(s) and thickness_m = "
                f"{self.thickness_m}, but a layered wall needs two layers or more, each with its "
                "own thickness_m; write a single slab without layers."
            )
            raise MaterialRangeError(msg)
        for i, layer in enumerate(self.layers):
            if layer.layers:
                msg = f"layer {i} of material {self.name!r} has layers itself; write one list."
                raise MaterialRangeError(msg)
            open_ended = layer.thickness_m is None and not layer.is_pec
            if open_ended and i < len(self.layers) - 1:
                msg = (
                    f"layer {i} ({layer.name}) of material {self.name!r} has no thickness_m, but "
                    "only the last layer may fill all that lies behind; give its thickness [m]."
                )
                raise MaterialRangeError(msg)

    def layer_stack(
        self, frequency_hz: float
    ) -> tuple[npt.NDArray[np.complex128], npt.NDArray[np.float64]]:
        """Return permittivity [-] (as `relative_permittivity`) and thickness [m] of each layer.

        From the front; infinitely thick where a layer fills all that lies behind.

        Parameters
        ----------
        frequency_hz : Frequency [Hz] within reach of the range of every layer.
        """
        layers = self.layers or (self,)
        permittivity = np.array([m.relative_permittivity(frequency_hz) for m in layers])
        thickness_m = [math.inf if m.thickness_m is None else m.thickness_m for m in layers]
        return permittivity, np.array(thickness_m)

    def relative_permittivity(self, frequency_hz: float) -> complex:
        """Return the complex relative permittivity eps' - j sigma / (omega eps_0) [-].

        For e^{+j omega t}; for PEC 1 - j inf. ITU-R P.2040-4 (2025), equations 9, 57 and 58.

        Parameters
        ----------
        frequency_hz : Frequency [Hz] within reach of the material's range.
        """
        if self.layers:
            msg = (
                f"material {self.name!r} has {len(self.layers)} layers and no permittivity of its "
                "own; ask for layer_stack."
            )
            raise MaterialRangeError(msg)
        self._check_range(frequency_hz)
        if self.is_pec:
            return complex(1.0, -math.inf)
        f_ghz = frequency_hz / 1e9
        eps_r = self.eps_r_a * f_ghz**self.eps_r_b
        sigma = self.sigma_c_s_per_m * f_ghz**self.sigma_d
        omega = 2.0 * math.pi * frequency_hz
        return complex(eps_r, -sigma / (omega * VACUUM_PERMITTIVITY_F_PER_M))

    def _check_range(self, frequency_hz: float) -> None:
        """Warn of a frequency [Hz] beyond the model's range, refuse one far beyond."""
        low, high = self.frequency_range_hz
        reach_hz = self.extrapolated_from_hz or low / EXTRAPOLATION
        near = reach_hz <= frequency_hz <= high * EXTRAPOLATION
        if not (math.isfinite(frequency_hz) and frequency_hz > 0.0 and near):
            msg = (
                f"material {self.name!r} is asked for at {frequency_hz / 1e9:g} GHz, but its model "
                f"holds from {low / 1e9:g} to {high / 1e9:g} GHz and is extrapolated from "
                f"{reach_hz / 1e9:g} to {high * EXTRAPOLATION / 1e9:g} GHz at most; choose another "
                "frequency or give a material {eps_r=, sigma_s_per_m=} of your own."
            )
            raise MaterialRangeError(msg)
        if not low <= frequency_hz <= high:
            msg = (
                f"material {self.name!r} is extrapolated: its model was fitted from {low / 1e9:g} "
                f"to {high / 1e9:g} GHz"
            )
            if frequency_hz < low / EXTRAPOLATION:
                msg += (
                    f", {low / frequency_hz:.2g} times this frequency; where it matters give a "
                    "material {eps_r=, sigma_s_per_m=} of your own"
                )
            msg += "."
            warnings.warn(msg, PhysicsWarning, stacklevel=3)


def _itu(
    name: str, abcd: tuple[float, float, float, float], low_ghz: float, high_ghz: float
) -> Material:
    a, b, c, d = abcd
    return Material(
        name=name,
        eps_r_a=a,
        eps_r_b=b,
        sigma_c_s_per_m=c,
        sigma_d=d,
        frequency_range_hz=(low_ghz * 1e9, high_ghz * 1e9),
    )


_TABLE = (
    _itu("air", (1.0, 0.0, 0.0, 0.0), 0.001, 100),
    _itu("concrete", (5.24, 0.0, 0.0462, 0.7822), 1, 100),
    _itu("brick", (3.91, 0.0, 0.0238, 0.16), 1, 40),
    _itu("plasterboard", (2.73, 0.0, 0.0085, 0.9395), 1, 100),
    _itu("wood", (1.99, 0.0, 0.0047, 1.0718), 0.001, 100),
    _itu("glass", (6.31, 0.0, 0.0036, 1.3394), 0.1, 100),
    _itu("ceiling_board", (1.48, 0.0, 0.0011, 1.0750), 1, 100),
    _itu("chipboard", (2.58, 0.0, 0.0217, 0.78), 1, 100),
    _itu("plywood", (2.71, 0.0, 0.33, 0.0), 1, 40),
    _itu("marble", (7.074, 0.0, 0.0055, 0.9262), 1, 60),
    # Nothing else there describes floors. Its permittivity has no trend over frequency; its loss
    # tangent comes out as 0.02 at 0.868 GHz, between wood's .04 and glass' .01.
    replace(
        _itu("floorboard", (3.66, 0.0, 0.0044, 1.3515), 50, 100),
        extrapolated_from_hz=LOWEST_RFID_HZ,
    ),
    Material(name="metal", sigma_c_s_per_m=1e7),  # from 1 to 100 GHz there; metal at any frequency
    _itu("very_dry_ground", (3.0, 0.0, 0.00015, 2.52), 1, 10),
    _itu("medium_dry_ground", (15.0, -0.1, 0.035, 1.63), 1, 10),
    _itu("wet_ground", (30.0, -0.4, 0.15, 1.30), 1, 10),
    Material(name="pec", is_pec=True),
)


def material_table() -> tuple[Material, ...]:
    """Return all known materials as half-spaces, ITU-R P.2040-4 Table 3 first, then ``pec``."""
    return _TABLE


def material(spec: str | Mapping[str, Any]) -> Material:
    """Return the material that a study file names or describes.

    Parameters
    ----------
    spec : A name of :func:`material_table` (``itu_`` before it is allowed); ``{name=,
        thickness_m=}``; ``{eps_r=, sigma_s_per_m=, thickness_m=}``, the last two optional [S/m, m];
        ``{layers=[...]}`` of such, front first, ``material=`` or ``name=``; or a table as text, as
        bodies carry it: ``"name = concrete, thickness_m = 0.1"``.
    """
    if isinstance(spec, str):
        return material(_table_of(spec)) if "=" in spec else _by_name(spec)
    allowed = ("name", "eps_r", "sigma_s_per_m", "thickness_m", "layers")
    for key in spec:
        if key not in allowed:
            msg = f"material key {key!r} is unknown; allowed are {', '.join(allowed)}."
            raise MaterialRangeError(msg)
    if "layers" in spec:
        return _layered(spec)
    thickness = spec.get("thickness_m")
    thickness = None if thickness is None else float(thickness)
    if "eps_r" in spec:
        eps_r, sigma = float(spec["eps_r"]), float(spec.get("sigma_s_per_m", 0.0))
        return Material(
            name=str(spec.get("name", f"eps_r={eps_r:g}, sigma={sigma:g} S/m")),
            eps_r_a=eps_r,
            sigma_c_s_per_m=sigma,
            thickness_m=thickness,
        )
    if "name" not in spec:
        msg = f"material {dict(spec)!r} has neither a name nor eps_r; give one of the two."
        raise MaterialRangeError(msg)
    if "sigma_s_per_m" in spec:
        msg = f"material {dict(spec)!r} gives sigma_s_per_m without eps_r; give both or neither."
        raise MaterialRangeError(msg)
    return replace(_by_name(str(spec["name"])), thickness_m=thickness)


def _layered(spec: Mapping[str, Any]) -> Material:
    if set(spec) - {"name", "layers"}:
        msg = (
            f"material {dict(spec)!r} gives {', '.join(sorted(set(spec) - {'name', 'layers'}))} "
            "beside layers; give these in each layer instead."
        )
        raise MaterialRangeError(msg)
    layers = tuple(material(_named(layer)) for layer in spec["layers"])
    if not layers:
        msg = "a material has an empty list of layers; give two or more, or a single material."
        raise MaterialRangeError(msg)
    name = str(spec.get("name", " | ".join(_layer_label(layer) for layer in layers)))
    return Material(name=name, layers=layers)


def _named(layer: str | Mapping[str, Any]) -> str | Mapping[str, Any]:
    """Return a layer with ``name`` in place of ``material``."""
    if isinstance(layer, str) or "material" not in layer:
        return layer
    if "name" in layer:
        msg = f"layer {dict(layer)!r} gives material and name, which mean the same; give one."
        raise MaterialRangeError(msg)
    return {"name" if key == "material" else key: value for key, value in layer.items()}


def _layer_label(layer: Material) -> str:
    if layer.thickness_m is None:
        return layer.name
    return f"{layer.name} {layer.thickness_m * 1e3:g} mm"


def _table_of(label: str) -> dict[str, str | float]:
    """Return the keys and values of a label such as ``eps_r = 4.0, thickness_m = 0.1``."""
    table: dict[str, str | float] = {}
    for part in label.split(","):
        key, _, value = (word.strip() for word in part.partition("="))
        try:
            table[key] = value if key == "name" else float(value)
        except ValueError as exc:
            msg = f"material {label!r} gives {key} as {value!r}, but a number is needed."
            raise MaterialRangeError(msg) from exc
    return table


def _by_name(name: str) -> Material:
    known = {m.name: m for m in _TABLE}
    key = name.strip().lower().removeprefix("itu_")
    if key in known:
        return known[key]
    near = known_as(key) or nearest_name(key, known)
    msg = f"material {name!r} is unknown; did you mean {near!r}? Known are {', '.join(known)}."
    raise MaterialRangeError(msg)
