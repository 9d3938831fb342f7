"""A reader at another band: in which range it has been compared, and the same in wavelengths."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgspec

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.geometries.errors import ConfigError
from octant.reader_design.study_file.reader import Reader

DESIGN_HZ = 2.4e9
"""Frequency for which the presets are drawn, and at which readers have been compared [Hz]."""
PRESETS_HZ: Mapping[str, float] = {
    "868 MHz": 866.5e6,
    "915 MHz": 915e6,
    "2.4 GHz": 2.44e9,
    "5.8 GHz": 5.8e9,
}
"""The bands of RFID that have a preset: ETSI 865 to 868 MHz, FCC 902 to 928 MHz, and the ISM bands
around 2.44 and 5.8 GHz."""
_SLACK = 1.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """A length of readers that have been compared with other solvers.

    Parameters
    ----------
    key, low, high : Key of ``[reader]``; least and greatest in wavelengths [-].
    """

    key: str
    low: float
    high: float


COMPARED = (
    Compared(key="antenna_radius_m", low=0.40, high=0.80),
    Compared(key="plate_height_m", low=0.0, high=1.2),
    Compared(key="gap_m", low=0.04, high=0.24),
    Compared(key="feed_gap_m", low=0.0, high=0.046),
)
"""At 2.4 GHz: r_a of 5 to 10 cm, plates up to 15 cm, gaps of 5 mm to 3 cm, feeds up to 5.7 mm; the
comparisons stand in docs/evidence/fullwave.md."""
LENGTHS_OF_READER = (
    "antenna_length_m",
    "antenna_radius_m",
    "plate_height_m",
    "plate_height_axis_m",
    "plate_outer_radius_m",
    "ground_plane_m",
    "gap_m",
    "monopole_plane_m",
    "wire_radius_m",
    "feed_gap_m",
)
"""Keys of ``[reader]`` that scale with the wavelength; its height above the floor does not."""

PRESET = Reader(
    antenna="dipole",
    antenna_length_m=0.0515,
    antenna_radius_m=0.0908,
    plate_height_m=0.0656,
    plate_height_axis_m=0.0989,
    plate_outer_radius_m=0.1,
    ground_plane_m=0.20,
    ground_plane_shape="octagon",
    gap_m=0.0061,
    load_ohm=121.0,
    wire_radius_m=0.0005,
    feed_gap_m=0.0057,
)
"""The reader that `octant optimise` found for 2.4 GHz (docs/evidence/designs.md)."""


def scaled(design: Reader, factor: float) -> Reader:
    """Return a reader all of whose lengths are multiplied: the same in wavelengths.

    Perfect metal has no scale of its own, so that ports and patterns are those of the original at
    the original's frequency over the factor. The surroundings and the height above the floor stay.

    Parameters
    ----------
    design, factor : The reader; by what its lengths are multiplied [-].
    """
    changes = {name: float(f"{factor * length:.4g}") for name, length in _lengths_m(design).items()}
    profile = tuple(float(f"{factor * height:.4g}") for height in design.plate_profile_m)
    return msgspec.structs.replace(design, plate_profile_m=profile, **changes)


def reader_preset(band: str | float) -> Reader:
    """Return a reader for a band: Octant's best for 2.4 GHz, scaled with the wavelength.

    Parameters
    ----------
    band : A name of `PRESETS_HZ`, or a frequency [Hz].
    """
    if isinstance(band, str):
        if band not in PRESETS_HZ:
            names = ", ".join(PRESETS_HZ)
            msg = f"band is {band!r}, but there are presets for {names}; choose one."
            raise ConfigError(msg)
        band = PRESETS_HZ[band]
    if not 1e6 <= band <= 1e12:
        msg = f"band is {band:g} Hz, but a frequency from 1e6 to 1e12 Hz is needed."
        raise ConfigError(msg)
    return scaled(PRESET, DESIGN_HZ / band)


def preset_keys(band: str | float) -> dict[str, Any]:
    """Return the keys of ``[reader]`` of a preset ([m], [ohm]), as a study file takes them.

    Parameters
    ----------
    band : As for `reader_preset` [Hz].
    """
    design = reader_preset(band)
    others = {name: getattr(design, name) for name in ("antenna", "ground_plane_shape", "load_ohm")}
    return {**others, **_lengths_m(design)}


def scale_note(design: Reader, frequency_hz: float) -> str | None:
    """Return what of a reader lies outside the range that has been compared, and what would not.

    Parameters
    ----------
    design, frequency_hz : The reader; the carrier [Hz].
    """
    if design.response != "fullwave":
        return None
    wavelength_m = SPEED_OF_LIGHT_M_PER_S / frequency_hz
    outside = []
    for item in COMPARED:
        share = getattr(design, item.key) / wavelength_m
        if not item.low / _SLACK <= share <= item.high * _SLACK:
            span = f"{item.low:g} to {item.high:g}" if item.low else f"up to {item.high:g}"
            outside.append(f"{item.key} is {share:.2g} wavelengths (compared: {span})")
    if not outside:
        return None
    text = (
        f"at {frequency_hz / 1e6:.4g} MHz the reader is outside the range in which it has been "
        f"compared with other solvers: {'; '.join(outside)}"
    )
    other = scaled(design, DESIGN_HZ / frequency_hz)
    if _inside(other, wavelength_m):
        keys = ", ".join(f"{name} = {length:g}" for name, length in _lengths_m(other).items())
        text += f". If it was drawn for {DESIGN_HZ / 1e9:g} GHz, the same in wavelengths is {keys}"
    return text


def _inside(design: Reader, wavelength_m: float) -> bool:
    return all(
        item.low / _SLACK <= getattr(design, item.key) / wavelength_m <= item.high * _SLACK
        for item in COMPARED
    )


def _lengths_m(design: Reader) -> dict[str, float]:
    """Return the lengths that a reader has, by key [m]."""
    found = {name: getattr(design, name) for name in LENGTHS_OF_READER}
    if design.antenna != "monopole":
        del found["monopole_plane_m"]
    return {name: length for name, length in found.items() if length is not None}
