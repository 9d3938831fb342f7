"""The kinds of quantity that keys of a study file hold, each with its least and greatest value.

A key has its range by its type: what lies outside is refused when the file is read, with a sentence
that names both ends. The ranges are wide: they keep out what no model here means, not what is rare.
Lengths, coordinates and distances in [m], angles in [deg].
"""

from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

from msgspec import Meta

# Radio
Frequency = Annotated[float, Meta(ge=1e6, le=1e12)]
"""Of waves [Hz]."""
Bandwidth = Annotated[float, Meta(ge=1.0, le=1e12)]
"""Of a receiver [Hz]."""
Power = Annotated[float, Meta(ge=1e-18, le=1e6)]
"""Sent or received [W]."""
PowerNanowatt = Annotated[float, Meta(ge=1e-9, le=1e12)]
"""The same [nW]."""
Level = Annotated[float, Meta(ge=-300.0, le=100.0)]
"""Power [dBm]."""
Ratio = Annotated[float, Meta(ge=-300.0, le=300.0)]
"""Of two powers [dB]."""
Deviation = Annotated[float, Meta(ge=0.0, le=100.0)]
"""Standard deviation of a level, or a loss [dB]."""
ShareLost = Annotated[float, Meta(ge=1e-3, le=100.0)]
"""Of a mean power, for what is not computed [dB]."""
Load = Annotated[float, Meta(ge=1e-3, le=1e6)]
"""Resistance [ohm]."""
LoadBound = Annotated[float, Meta(ge=0.0, le=1e6)]
"""The same, or a bound of it [ohm]."""
Permittivity = Annotated[float, Meta(ge=1.0, le=1e5)]
"""Real part of the relative permittivity [-]."""
Conductivity = Annotated[float, Meta(ge=0.0, le=1e9)]
"""Of a material [S/m]."""
MetalConductivity = Annotated[float, Meta(ge=1e4, le=1e9)]
"""Of a metal [S/m]."""
SheetThickness = Annotated[float, Meta(ge=1e-8, le=0.1)]
"""Of a sheet of metal [m]."""
Roughness = Annotated[float, Meta(ge=1.0, le=10.0)]
"""Resistance of a surface over that of a smooth one [-]."""
Thickness = Annotated[float, Meta(ge=1e-6, le=1e3)]
"""Of a layer of a wall [m]."""

# Space
Coordinate = Annotated[float, Meta(ge=-1e7, le=1e7)]
"""Of a place [m]; national grids fit in."""
Point = tuple[Coordinate, Coordinate, Coordinate]
Spot = tuple[Coordinate, Coordinate]
Extent = Annotated[float, Meta(ge=1e-4, le=1e3)]
"""Of a room, or of what stands in it [m]."""
Size = tuple[Extent, Extent, Extent]
Distance = Annotated[float, Meta(ge=1e-4, le=1e4)]
"""Between places, or a radius around one [m]."""
DistanceOrZero = Annotated[float, Meta(ge=0.0, le=1e4)]
"""The same, or 0 [m]."""
Part = Annotated[float, Meta(ge=1e-6, le=100.0)]
"""Length of a part of a reader [m]."""
PartOrZero = Annotated[float, Meta(ge=0.0, le=100.0)]
"""The same; 0: the part is not there [m]."""
Component = Annotated[float, Meta(ge=-1e9, le=1e9)]
"""Of a direction of any length."""
Direction = tuple[Component, Component, Component]
Angle = Annotated[float, Meta(ge=-3600.0, le=3600.0)]
"""Direction or turn [deg]."""
AngleDeviation = Annotated[float, Meta(ge=1e-6, le=360.0)]
"""Standard deviation of an angle [deg]."""

# Time and motion
Period = Annotated[float, Meta(ge=1e-3, le=1e3)]
"""From one step to the next [s]."""
PeriodOrZero = Annotated[float, Meta(ge=0.0, le=1e3)]
"""The same, or 0: at once [s]."""
Duration = Annotated[float, Meta(ge=1e-3, le=1e6)]
"""Of a drive [s]."""
DurationOrZero = Annotated[float, Meta(ge=0.0, le=1e6)]
"""The same, or 0: never [s]."""
Speed = Annotated[float, Meta(ge=1e-4, le=100.0)]
"""Of a robot [m/s]."""
SpeedError = Annotated[float, Meta(ge=-10.0, le=10.0)]
"""Of a robot [m/s]."""
TurnRate = Annotated[float, Meta(ge=1e-2, le=1e4)]
"""Of a robot [deg/s]."""
TurnRateError = Annotated[float, Meta(ge=-360.0, le=360.0)]
"""Of a robot [deg/s]."""
WheelRate = Annotated[float, Meta(ge=1e-2, le=1e4)]
"""Of a wheel [rad/s]."""
WheelRateDeviation = Annotated[float, Meta(ge=0.0, le=1e3)]
"""Of a wheel [rad/s]."""
WheelAcceleration = Annotated[float, Meta(ge=1e-3, le=1e6)]
"""Of a wheel [rad/s²]."""
TurnAcceleration = Annotated[float, Meta(ge=1e-2, le=1e6)]
"""Of a robot [deg/s²]."""
SteeringLimit = Annotated[float, Meta(ge=0.1, le=89.0)]
"""Of a car's front wheels [deg]."""
Gain = Annotated[float, Meta(ge=1e-6, le=1e6)]
"""Of a control law [1/s], [-]."""

# Numbers
Share = Annotated[float, Meta(ge=0.0, le=1.0)]
"""Share or probability [-]."""
Percent = Annotated[float, Meta(ge=0.0, le=99.0)]
"""Error [%]."""
Number = Annotated[float, Meta(ge=-1e9, le=1e9)]
"""Of any unit."""
Weight = Annotated[float, Meta(ge=1e-9, le=1e9)]
"""How much something counts."""
Swept = Annotated[float, Meta(ge=-1e12, le=1e12)]
"""First or last value of a swept key, in the key's unit."""
Step = Annotated[float, Meta(ge=1e-12, le=1e12)]
"""Between two of them."""
NotNegative = Annotated[float, Meta(ge=0.0, le=1e9)]
"""Of any unit."""
Seed = Annotated[int, Meta(ge=0, le=2**63 - 1)]
Count = Annotated[int, Meta(ge=1, le=1_000_000)]
CountOrZero = Annotated[int, Meta(ge=0, le=1_000_000)]
Antennas = Annotated[int, Meta(ge=3, le=100)]
"""Of a reader."""
Cells = Annotated[float, Meta(ge=4.0, le=40.0)]
"""Elements of a mesh per wavelength [-]."""

# Texts
PRINTABLE = r"^(?!\s*$)[^\x00-\x1f\x7f]+\Z"
"""Not blank, and without control characters."""
FOR_FILES = r"^(?!\s*$)[^/\\\x00-\x1f\x7f]+\Z"
"""The same, and without separators of paths."""
Name = Annotated[str, Meta(min_length=1, max_length=100, pattern=FOR_FILES)]
"""What a person calls something."""
Word = Annotated[str, Meta(min_length=1, max_length=200, pattern=PRINTABLE)]
"""A material, a unit, or a body in a mesh file."""
FileName = Annotated[str, Meta(min_length=1, max_length=1000, pattern=PRINTABLE)]
"""Path of a file; of an antenna its kind, or its file."""


def limits(kind: Any) -> tuple[type, Meta] | None:  # noqa: ANN401  any annotation
    """Return the type and the limits of the numbers or texts that a type allows; None without any.

    Parameters
    ----------
    kind : Type of a key, ``Frequency | None`` for example.
    """
    found = [arg for arg in get_args(kind) if isinstance(arg, Meta)]
    if found and get_args(kind)[0] in {int, float, str}:
        return get_args(kind)[0], found[0]
    members = get_args(kind) if get_origin(kind) in {Union, UnionType} else ()
    return next(filter(None, map(limits, members)), None)


def range_text(kind: type, meta: Meta, unit: str = "") -> str:
    """Return what is allowed in words, for example ``a number from 1e6 to 1e12 Hz``.

    Parameters
    ----------
    kind, meta : From `limits`.
    unit : Unit of the number.
    """
    if kind is str:
        slash = ", / and \\" if meta.pattern == FOR_FILES else ""
        return f"text of 1 to {meta.max_length} characters without control characters{slash}"
    word = "a whole number" if kind is int else "a number"
    low, high = (_short(end or 0) for end in (meta.ge, meta.le))
    return f"{word} from {low} to {high} {unit}".rstrip()


def _short(number: float) -> str:
    if isinstance(number, int):
        return str(number)
    text = f"{number:.10g}" if 1e-4 <= abs(number) < 1e6 else f"{number:g}"
    return text.replace("e+", "e").replace("e0", "e").replace("e-0", "e-")
