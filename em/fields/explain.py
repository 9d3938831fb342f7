"""One path's budget in decibels, interaction by interaction, as a chain that adds up to its gain.

As `octant.em.fields.gains.path_gains`, but step by step in plain arrays, one line a step.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna
from octant.em.fields._diffraction_kernels import along_edge, diffract, diffract_twice
from octant.em.fields._field_kernels import leaving
from octant.em.medium.materials import Material
from octant.em.medium.radio_scene import RadioScene
from octant.em.medium.reflection import WallCoefficients, wall_coefficients
from octant.em.paths.tracing import scene_arrays
from octant.em.records import DIFFRACTION, NOTHING, REFLECTION, TRANSMITTED, PathSet
from octant.geometries._wedge_kernels import one_facet
from octant.geometries.errors import GeometryError

FloatArray = npt.NDArray[np.float64]
ComplexArray = npt.NDArray[np.complex128]

NORMAL_INCIDENCE = 1e-9
"""Sine of the angle from the normal [-] below which a plane of incidence has no direction."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BudgetLine:
    """One line of a budget: what a step does to the magnitude of the field.

    Parameters
    ----------
    step : ``transmitter``, ``free space``, ``reflection``, ``transmission``, ``diffraction``,
        ``double diffraction``, ``polarisation`` or ``receiver``.
    change_db : Change of the level [dB]; minus infinity where nothing is left.
    detail : In words.
    place_m : Where it happens, (3,) [m].
    element : Facet that is hit, or wedge.
    material : Its material.
    incidence_rad : Angle from the normal of the facet [rad].
    te, tm : Coefficients [-] of the field across and in the plane of incidence.
    te_share : Share of the arriving power that is TE [-].
    """

    step: str
    change_db: float
    detail: str
    place_m: tuple[float, float, float] | None = None
    element: int | None = None
    material: str | None = None
    incidence_rad: float | None = None
    te: complex | None = None
    tm: complex | None = None
    te_share: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class PathBudget:
    """The budget of one path between two antennas.

    Parameters
    ----------
    lines : From transmitter to receiver; the polarisation's mismatch stands before the receiver.
    gain : Complex gain of the path [-], free-space loss and phase included.
    length_m : Length [m].
    vertices_m : (n, 3) float64 — Source, places of the interactions, receiver [m].
    """

    lines: tuple[BudgetLine, ...]
    gain: complex
    length_m: float
    vertices_m: FloatArray

    @property
    def gain_db(self) -> float:
        """Gain of the path [dB], which the lines add up to."""
        return _power_db(abs(self.gain) ** 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Wave:
    """A wave between two interactions: where it goes, and its field with spreading taken out."""

    direction: FloatArray
    field: ComplexArray

    @property
    def magnitude(self) -> float:
        return float(np.linalg.norm(self.field))


def explain_path(
    radio: RadioScene, paths: PathSet, path: int, *, transmitter: Antenna, receiver: Antenna
) -> PathBudget:
    """Return the budget of one path between two antennas [dB].

    Transmitter and receiver: |F|^2 in the path's direction. Free space: (lambda / 4 pi L)^2 over
    the unfolded length L. An interaction: (|E after| / |E before|)^2 of the field as polarised
    there, between the losses of TE and TM; a diffraction with its own spreading against the
    spherical wave's, two edges in a row as one line. Polarisation: |F_r . E|^2 / (|F_r| |E|)^2.
    Where a field vanishes its line is minus infinity and later ones, which would be 0/0, are 0 dB.

    Parameters
    ----------
    radio : Scene that the paths were traced in.
    paths : Paths.
    path : Row of the path.
    transmitter, receiver : Antennas at the two ends, in the room's frame.
    """
    if not 0 <= path < len(paths):
        msg = f"path {path} does not exist; the paths are numbered 0 to {len(paths) - 1}."
        raise GeometryError(msg)
    vertices = paths.vertices_of(path)
    length_m = float(paths.length_m[path])
    leg = vertices[1] - vertices[0]
    direction = leg / np.linalg.norm(leg)
    wave = _Wave(direction=direction, field=_pattern(transmitter, direction))
    lines = [
        BudgetLine(
            step="transmitter",
            change_db=_power_db(wave.magnitude**2),
            detail=f"{transmitter.kind} towards {_angles(direction)}",
            place_m=_point(vertices[0]),
        )
    ]
    loss = radio.wavelength_m / (4.0 * math.pi * length_m)
    lines.append(
        BudgetLine(
            step="free space",
            change_db=_power_db(loss**2),
            detail=f"{length_m:.4f} m at {radio.frequency_hz / 1e9:g} GHz",
        )
    )
    hops = _hops(radio, paths, path)
    for hop in hops:
        wave, line = _STEPS[hop.kind](radio, wave, hop)
        lines.append(line)
    taken = _pattern(receiver, -wave.direction)
    voltage = complex(wave.field @ taken)
    most = wave.magnitude * float(np.linalg.norm(taken))
    lines.append(
        BudgetLine(
            step="polarisation",
            change_db=_power_db((abs(voltage) / most) ** 2) if most > 0.0 else 0.0,
            detail="field against the receiving antenna",
        )
    )
    lines.append(
        BudgetLine(
            step="receiver",
            change_db=_power_db(float(np.linalg.norm(taken)) ** 2),
            detail=f"{receiver.kind} towards {_angles(-wave.direction)}",
            place_m=_point(vertices[-1]),
        )
    )
    # Whole turns go first: a phase of thousands of radians would lose digits.
    turn = -2.0 * math.pi * math.fmod(length_m / radio.wavelength_m, 1.0)
    return PathBudget(
        lines=tuple(lines),
        gain=voltage * loss * complex(math.cos(turn), math.sin(turn)),
        length_m=length_m,
        vertices_m=vertices,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class _Hop:
    """One interaction, or two edges in a row: where it is, and the lengths on either side."""

    kind: int
    elements: tuple[int, ...]
    places_m: FloatArray
    before_m: float
    after_m: float
    directions: FloatArray  # from each place towards the next vertex


_Step = Callable[[RadioScene, _Wave, _Hop], tuple[_Wave, BudgetLine]]


def _hops(radio: RadioScene, paths: PathSet, path: int) -> list[_Hop]:
    """Return the interactions of a path from the source on, edges in a row taken together."""
    vertices = paths.vertices_of(path)
    length = np.linalg.norm(np.diff(vertices, axis=0), axis=1)
    arrays = scene_arrays(radio)
    codes = paths.codes[path, : len(length) - 1]
    backwards = (vertices[None, ::-1].copy(), codes[None, ::-1].copy(), 0)
    unit = np.array(
        [
            leaving(arrays.planes, arrays.facet_plane, arrays.tolerance, *backwards, leg)
            for leg in range(len(length) - 1, -1, -1)
        ]
    )
    kinds = [int(k) for k in paths.kind[path] if k != NOTHING]
    hops = []
    first = 0
    while first < len(kinds):
        last = first
        while kinds[first] == DIFFRACTION and kinds[last + 1 : last + 2] == [DIFFRACTION]:
            last += 1
        hops.append(
            _Hop(
                kind=kinds[first],
                elements=tuple(int(e) for e in paths.element[path, first : last + 1]),
                places_m=vertices[first + 1 : last + 2],
                before_m=float(length[: first + 1].sum()),
                after_m=float(length[last + 1 :].sum()),
                directions=unit[first + 1 : last + 2],
            )
        )
        first = last + 1
    return hops


def _reflection(radio: RadioScene, wave: _Wave, hop: _Hop) -> tuple[_Wave, BudgetLine]:
    """Return the wave after a reflection and its line."""
    return _at_wall(radio, wave, hop, reflected=True)


def _transmission(radio: RadioScene, wave: _Wave, hop: _Hop) -> tuple[_Wave, BudgetLine]:
    """Return the wave behind a sheet and its line."""
    return _at_wall(radio, wave, hop, reflected=False)


def _at_wall(
    radio: RadioScene, wave: _Wave, hop: _Hop, *, reflected: bool
) -> tuple[_Wave, BudgetLine]:
    facets, facet = radio.scene.facets, hop.elements[0]
    normal = facets.plane_normal[facets.facet_plane[facet]]
    inward = wave.direction
    from_front = bool((inward @ normal <= 0.0) == radio.scene.facet_front[facet])
    if inward @ normal > 0.0:
        normal = -normal
    cosine = min(-float(inward @ normal), 1.0)
    wall = radio.materials[facets.facet_material[facet]]
    incidence = math.acos(cosine)
    coefficients = wall_coefficients(wall, radio.frequency_hz, [incidence], from_front=from_front)
    te, tm = _te_tm(radio, wall, coefficients, cosine, reflected=reflected)
    outward = inward + 2.0 * cosine * normal if reflected else inward
    across = np.cross(inward, normal)
    sine = float(np.linalg.norm(across))
    before = wave.magnitude
    if sine < NORMAL_INCIDENCE:  # one coefficient, and any transverse direction is perpendicular
        field, share = te * wave.field, None
    else:
        across = across / sine
        in_te = wave.field @ across
        in_tm = wave.field @ np.cross(across, inward)
        field = te * in_te * across + tm * in_tm * np.cross(across, outward)
        share = min(float(abs(in_te)) ** 2 / before**2, 1.0) if before > 0.0 else None
    after = float(np.linalg.norm(field))
    line = BudgetLine(
        step="reflection" if reflected else "transmission",
        change_db=_power_db((after / before) ** 2) if before > 0.0 else 0.0,
        detail=f"{wall_text(wall.name, wall.thickness_m)}, facet {facet}",
        place_m=_point(hop.places_m[0]),
        element=facet,
        material=wall_text(wall.name, wall.thickness_m),
        incidence_rad=incidence,
        te=te,
        tm=tm,
        te_share=share,
    )
    return _Wave(direction=outward, field=field), line


def _te_tm(
    radio: RadioScene,
    wall: Material,
    coefficients: WallCoefficients,
    cosine: float,
    *,
    reflected: bool,
) -> tuple[complex, complex]:
    """Return the two coefficients; those of transmission in place of the air that is displaced."""
    if reflected:
        return complex(coefficients.reflection_te[0]), complex(coefficients.reflection_tm[0])
    depth_m = float(np.sum(wall.layer_stack(radio.frequency_hz)[1]))
    turn = 2.0 * math.pi * depth_m / radio.wavelength_m * cosine
    air = complex(math.cos(turn), math.sin(turn))
    return (
        air * complex(coefficients.transmission_te[0]),
        air * complex(coefficients.transmission_tm[0]),
    )


def _diffraction(radio: RadioScene, wave: _Wave, hop: _Hop) -> tuple[_Wave, BudgetLine]:
    """Return the wave behind one edge, or behind two in a row, and its line."""
    arrays = scene_arrays(radio)
    wedges = radio.wedges
    between = float(np.linalg.norm(np.diff(hop.places_m, axis=0)))
    total = hop.before_m + between + hop.after_m
    common = (
        arrays.wedge_utd,
        arrays.wedge_faces,
        arrays.layer_permittivity,
        arrays.layer_thickness,
    )
    wavenumber = 2.0 * math.pi / radio.wavelength_m
    along = [
        along_edge(arrays.wedge_utd, w, place)
        for w, place in zip(hop.elements, hop.places_m, strict=True)
    ]
    if len(hop.elements) == 1:
        field = diffract(
            *common,
            hop.elements[0],
            wavenumber,
            arrays.tolerance,
            *along,
            hop.before_m,
            hop.after_m,
            *wave.direction,
            *hop.directions[0],
            *wave.field,
        )
        spread = math.sqrt(hop.before_m * hop.after_m * total)
    else:
        field = diffract_twice(
            *common,
            *hop.elements,
            one_facet(arrays.wedge_facets, *hop.elements),
            wavenumber,
            arrays.tolerance,
            *along,
            hop.before_m,
            between,
            hop.after_m,
            *wave.direction,
            *hop.directions[0],
            *hop.directions[1],
            *wave.field,
        )
        spread = math.sqrt(hop.before_m * between * hop.after_m * total)
    behind = np.array(field, dtype=np.complex128) * (total / spread)
    before, after = wave.magnitude, float(np.linalg.norm(behind))
    angles = " and ".join(f"{math.degrees(wedges.exterior_rad[w]):.0f}°" for w in hop.elements)
    line = BudgetLine(
        step="diffraction" if len(hop.elements) == 1 else "double diffraction",
        change_db=_power_db((after / before) ** 2) if before > 0.0 else 0.0,
        detail=f"air of {angles}, wedge {', '.join(str(w) for w in hop.elements)}",
        place_m=_point(hop.places_m[0]),
        element=hop.elements[0],
        material=" / ".join(_face_names(radio, hop.elements[0])),
    )
    return _Wave(direction=hop.directions[-1], field=behind), line


def _face_names(radio: RadioScene, wedge: int) -> list[str]:
    material = radio.scene.facets.facet_material[radio.wedges.facets[wedge]]
    names = [wall_text(radio.materials[m].name, radio.materials[m].thickness_m) for m in material]
    return list(dict.fromkeys(names))


_STEPS: dict[int, _Step] = {
    REFLECTION: _reflection,
    TRANSMITTED: _transmission,
    DIFFRACTION: _diffraction,
}
"""One function for each kind of interaction: the wave before it gives the wave after and a line.

Spreading of a spherical wave over the whole length is taken out; an edge's own is in its line.
"""


def wall_text(name: str, thickness_m: float | None) -> str:
    """Return what people call a wall: its material, and its thickness where it is a slab.

    Parameters
    ----------
    name : Material.
    thickness_m : Thickness [m]; None for a half-space.
    """
    return name if thickness_m is None else f"{name} {1e3 * thickness_m:g} mm"


def _pattern(antenna: Antenna, direction: FloatArray) -> ComplexArray:
    """Return the far-field vector (3,) [-] of an antenna in the room's frame."""
    across = math.hypot(direction[0], direction[1])
    theta, phi = math.atan2(across, direction[2]), math.atan2(direction[1], direction[0])
    f_theta, f_phi = antenna.far_field(theta, phi)
    st, ct, sp, cp = math.sin(theta), math.cos(theta), math.sin(phi), math.cos(phi)
    unit = np.array([[ct * cp, ct * sp, -st], [-sp, cp, 0.0]])
    vector: ComplexArray = np.array([f_theta, f_phi]) @ unit
    return vector


def _angles(direction: FloatArray) -> str:
    theta = math.degrees(math.atan2(math.hypot(direction[0], direction[1]), direction[2]))
    phi = math.degrees(math.atan2(direction[1], direction[0])) % 360.0
    return f"theta {theta:.1f}°, phi {phi:.1f}°"


def _point(place_m: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(c) for c in place_m)
    return x, y, z


def _power_db(ratio: float) -> float:
    return 10.0 * math.log10(ratio) if ratio > 0.0 else -math.inf
