"""Readers of any metal: the tables ``[[reader.body]]`` and ``[[reader.port]]``."""

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np
import numpy.typing as npt
from msgspec import Meta

from octant.em.constants import SPEED_OF_LIGHT_M_PER_S
from octant.em.reader.fullwave.conductor import Conductor
from octant.em.reader.fullwave.elements import (
    Part,
    copied_around,
    dipole_parts,
    inverted_f_parts,
    loop_parts,
    patch_parts,
)
from octant.em.reader.fullwave.ported import GROUND, PortedMesh, ported_mesh, refined
from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries.errors import ConfigError
from octant.geometries.mesh_files import mesh_object
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.study_file import quantities
from octant.reader_design.study_file.quantities import (
    Angle,
    Direction,
    FileName,
    PartOrZero,
    Point,
    Word,
)
from octant.reader_design.study_file.room import Table, UpAxis

Length = quantities.Part
Around = Annotated[int, Meta(ge=1, le=100)]
Pair = tuple[Word, Word]


class MetalBody(Table, frozen=True, kw_only=True):
    """What every body of a reader of any metal has.

    Parameters
    ----------
    name : What ports call it; its parts are ``name.part``.
    position_m : (3,) tuple of float — Place in the reader's frame [m], of the file's origin, of the
        middle of a dipole or loop, of the foot of an inverted F, of the point below a patch.
    around : Copies in even steps around the reader's axis; several are called ``name 1`` and so on.
    """

    name: Word
    position_m: Point = (0.0, 0.0, 0.0)
    around: Around = 1


class FileBody(MetalBody, frozen=True, kw_only=True, tag_field="kind", tag="mesh"):
    """Metal from a mesh file: ``[[reader.body]]`` with ``kind = "mesh"``.

    Parameters
    ----------
    file : Mesh file of triangles, relative to the study file; its bodies are the parts. A single
        body is called ``name`` alone.
    unit : Length unit of the file, such as m, cm, mm, in; needed unless the format declares one.
    up : The file's vertical axis, ``y`` or ``z``; None: y for GLB and GLTF, z for the others.
    yaw_deg : Turn about the vertical through ``position_m``, counter-clockwise from above [deg].
    """

    file: FileName
    unit: Word | None = None
    up: UpAxis | None = None
    yaw_deg: Angle = 0.0

    def parts(self, cell_m: float) -> list[Part]:
        """Return its named parts [m], as they stand in the file.

        Parameters
        ----------
        cell_m : Longest cell [m]; triangles are halved later.
        """
        del cell_m
        bodies = mesh_object(
            self.file,
            unit=self.unit,
            up=self.up,
            material="pec",
            position_m=self.position_m,
            yaw_deg=self.yaw_deg,
        )
        single = len(bodies) == 1
        return [("" if single else b.name, b.vertices_m, b.faces) for b in bodies]


class DipoleBody(MetalBody, frozen=True, kw_only=True, tag_field="kind", tag="dipole"):
    """A dipole of any direction: ``[[reader.body]]`` with ``kind = "dipole"``.

    Its parts ``low`` and ``high`` meet at the feed.

    Parameters
    ----------
    length_m : Length [m].
    axis : Direction from low to high, where the first copy stands, on +x: [0, 0, 1] is upright,
        [0, 1, 1] slanted by 45 degrees across the radius, [1, 0, 1] leaning outwards.
    wire_radius_m : Radius of the wire [m].
    """

    length_m: Length
    axis: Direction = (0.0, 0.0, 1.0)
    wire_radius_m: Length = 0.0005

    def parts(self, cell_m: float) -> list[Part]:
        """Return its named parts [m].

        Parameters
        ----------
        cell_m : Longest cell [m].
        """
        return dipole_parts(
            length_m=self.length_m,
            width_m=4.0 * self.wire_radius_m,
            middle_m=self.position_m,
            axis=self.axis,
            cell_m=cell_m,
        )


class LoopBody(MetalBody, frozen=True, kw_only=True, tag_field="kind", tag="loop"):
    """A rectangular loop across the radius: ``[[reader.body]]`` with ``kind = "loop"``.

    A narrow one of half a wave's height is a folded dipole. ``low`` and ``high`` meet at the feed
    in the middle of one upright side; ``rest`` closes the loop.

    Parameters
    ----------
    size_m : (2,) tuple of float — Width across the radius and height [m].
    wire_radius_m : Radius of the wire [m].
    """

    size_m: tuple[Length, Length]
    wire_radius_m: Length = 0.0005

    def parts(self, cell_m: float) -> list[Part]:
        """Return its named parts [m].

        Parameters
        ----------
        cell_m : Longest cell [m].
        """
        return loop_parts(
            size_m=self.size_m,
            width_m=4.0 * self.wire_radius_m,
            middle_m=self.position_m,
            cell_m=cell_m,
        )


class InvertedFBody(MetalBody, frozen=True, kw_only=True, tag_field="kind", tag="inverted_f"):
    """An inverted-F antenna of strips: ``[[reader.body]]`` with ``kind = "inverted_f"``.

    Over the infinite plane; the port lies between ``ground`` and its part ``leg``; the others are
    its part ``metal``.

    Parameters
    ----------
    height_m, arm_m : Height of the arm over the plane, its length from the shorted end [m].
    tap_m : Distance of the leg from the post that shorts the arm [m].
    width_m : Width of the strips [m].
    """

    height_m: Length
    arm_m: Length
    tap_m: Length
    width_m: Length = 0.002

    def parts(self, cell_m: float) -> list[Part]:
        """Return its named parts [m].

        Parameters
        ----------
        cell_m : Longest cell [m].
        """
        return inverted_f_parts(
            height_m=self.height_m,
            arm_m=self.arm_m,
            tap_m=self.tap_m,
            width_m=self.width_m,
            foot_m=self.position_m,
            cell_m=cell_m,
        )


class PatchBody(MetalBody, frozen=True, kw_only=True, tag_field="kind", tag="patch"):
    """A patch on air over the infinite plane: ``[[reader.body]]`` with ``kind = "patch"``.

    The port lies between ``ground`` and its part ``probe``; the sheet is its part ``patch``.

    Parameters
    ----------
    size_m : (2,) tuple of float — Resonant length across the radius, width along it [m].
    height_m : Height over the plane [m].
    feed_m : Distance of the probe from the middle, along the length [m].
    """

    size_m: tuple[Length, Length]
    height_m: Length
    feed_m: PartOrZero

    def parts(self, cell_m: float) -> list[Part]:
        """Return its named parts [m].

        Parameters
        ----------
        cell_m : Longest cell [m].
        """
        return patch_parts(
            size_m=self.size_m,
            height_m=self.height_m,
            feed_m=self.feed_m,
            middle_m=self.position_m,
            cell_m=min(cell_m, 1.2 * self.height_m),
        )


class OwnBody(MetalBody, frozen=True, kw_only=True, tag_field="kind", tag="reader"):
    """The reader's own ground plane and plates: ``[[reader.body]]`` with ``kind = "reader"``.

    As the keys of ``[reader]`` give them, with its ``[[reader.object]]``, without its antennas; a
    single part of the body's name. Other bodies stand beside it and do not touch it. The mesh is
    fine below the ring of ``antenna_radius_m``.
    """


Body = OwnBody | FileBody | DipoleBody | LoopBody | InvertedFBody | PatchBody


class ReaderPort(Table, frozen=True, kw_only=True):
    """A port of a reader of any metal: ``[[reader.port]]``.

    Parameters
    ----------
    between : Names of the two parts that meet at its edges: a positive voltage drives current from
        the first into the second. ``ground`` is the infinite plane. Of bodies with copies around
        the axis each copy has one, in order; of several tables with as many copies the first
        copies of all come first.
    second : A second pair of parts of the same antenna, fed through an ideal hybrid of 50 ohm with
        half of the power each; None: the antenna has one port.
    phase_deg : By how much the second is behind the first [deg]: 90 or -90 for circular
        polarisation.
    """

    between: Pair
    second: Pair | None = None
    phase_deg: Angle = 90.0


def check_metal(
    bodies: Sequence[Body],
    ports: Sequence[ReaderPort],
    *,
    antennas: int,
    response: str,
    ground: str,
) -> None:
    """Refuse bodies and ports that do not fit to the reader's other keys.

    Parameters
    ----------
    bodies, ports, ground, antennas, response : Keys of ``[reader]``.
    """
    if response != "metal":
        if bodies or ports or ground != "none":
            msg = (
                f"reader.body, reader.port or reader.ground is given, but reader.response is "
                f'{response!r}; set reader.response = "metal", or leave them out.'
            )
            raise ConfigError(msg)
        return
    names = [body.name for body in bodies]
    for i, name in enumerate(names):
        if name in names[:i] or name == GROUND:
            msg = f"reader.body[{i}].name is {name!r}, which is taken; give another name."
            raise ConfigError(msg)
    made = len(hybrid_shares(bodies, ports))
    if made != antennas:
        msg = (
            f"reader.body and reader.port make {made} ports, but reader.antennas is "
            f"{antennas}, and antenna i at an azimuth of (i - 1) / {antennas} of a turn is port i; "
            "give as many."
        )
        raise ConfigError(msg)


def antenna_ports(
    bodies: Sequence[Body], ports: Sequence[ReaderPort]
) -> list[tuple[ReaderPort, list[Pair]]]:
    """Return the table of each antenna, and the names of the two parts of its one or two ports.

    Copies stand one after the other; of several tables with as many copies, as of several rings,
    the first copies of all come first, so that antennas follow each other around the axis.

    Parameters
    ----------
    bodies, ports : The tables.
    """
    around = {body.name: body.around for body in bodies if body.around > 1}

    def numbered(name: str, i: int) -> str:
        head, dot, part = name.partition(".")
        return f"{head} {i + 1}{dot}{part}" if head in around else name

    each = []
    for port in ports:
        both = [port.between] if port.second is None else [port.between, port.second]
        copies = max(around.get(n.partition(".")[0], 1) for pair in both for n in pair)
        each.append(
            [
                (port, [(numbered(one, i), numbered(other, i)) for one, other in both])
                for i in range(copies)
            ]
        )
    if len({len(copies) for copies in each}) == 1:
        return [copies[i] for i in range(len(each[0])) for copies in each]
    return [one for copies in each for one in copies]


def hybrid_shares(
    bodies: Sequence[Body], ports: Sequence[ReaderPort]
) -> npt.NDArray[np.complex128]:
    """Return (n, N) what of a wave into each antenna comes to each of all ports [-].

    Parameters
    ----------
    bodies, ports : The tables.
    """
    antennas = antenna_ports(bodies, ports)
    count = sum(len(pairs) for _, pairs in antennas)
    shares = np.zeros((len(antennas), count), dtype=np.complex128)
    half, at = math.sqrt(0.5), 0
    for row, (port, pairs) in zip(shares, antennas, strict=True):
        own = [1.0 + 0j]
        if port.second is not None:
            own = [half + 0j, half * cmath.exp(-1j * math.radians(port.phase_deg))]
        row[at : at + len(pairs)] = own
        at += len(pairs)
    return shares


def azimuth_doubts(centres_m: FloatArray) -> tuple[str, ...]:
    """Return a warning where antennas stand elsewhere than their number says.

    Parameters
    ----------
    centres_m : (n, 3) float64 — Places of the antennas in their order [m].
    """
    count = len(centres_m)
    counted = 2.0 * math.pi * np.arange(count) / count
    found = np.arctan2(centres_m[:, 1], centres_m[:, 0])
    off = np.abs((found - counted + math.pi) % (2.0 * math.pi) - math.pi)
    off[np.hypot(centres_m[:, 0], centres_m[:, 1]) < LENGTHS.place_m] = 0.0
    wrong = np.flatnonzero(off > math.pi / count + LENGTHS.same_share)
    if not len(wrong):
        return ()
    i = int(wrong[0])
    text = (
        f"the port of antenna {i + 1} stands at {math.degrees(found[i]) % 360.0:.4g} deg, but the "
        f"antenna counts as one at {math.degrees(counted[i]):.4g} deg, as {count} in even steps "
        "do: its bearings mean nothing; stagger rings that are fed apart, or feed one ring alone"
    )
    return (text,)


def metal_mesh(
    bodies: Sequence[Body],
    ports: Sequence[ReaderPort],
    *,
    frequency_hz: float,
    cells_per_wavelength: float,
    ground: str,
    refine: bool,
    conductor: Conductor | None,
    own: Callable[[], tuple[FloatArray, IntArray]],
) -> PortedMesh:
    """Return the mesh of a reader of any metal.

    Parameters
    ----------
    bodies, ports, cells_per_wavelength, ground, refine : Keys of ``[reader]``.
    frequency_hz : Frequency that it is meshed for [Hz].
    conductor : What the metal is made of; None: it is perfect.
    own : Makes vertices [m] and triangles of the reader's own ground plane and plates.
    """
    cell_m = SPEED_OF_LIGHT_M_PER_S / frequency_hz / cells_per_wavelength
    parts: list[Part] = []
    given: list[Part] = []
    wires_m: dict[str, float] = {}
    for body in bodies:
        made = [("", *own())] if isinstance(body, OwnBody) else body.parts(cell_m)
        copies = copied_around(made, body.name, around=body.around)
        if isinstance(body, DipoleBody | LoopBody):
            wires_m |= {name: body.wire_radius_m for name, _, _ in copies}
        into = given if isinstance(body, FileBody) and refine else parts
        into += [(name.removesuffix("."), points, faces) for name, points, faces in copies]
    mesh = ported_mesh(
        [*refined(given, edge_m=cell_m), *parts],
        [pair for _, pairs in antenna_ports(bodies, ports) for pair in pairs],
        frequency_hz=frequency_hz,
        ground=ground == "infinite",
        conductor=conductor,
        wires_m=wires_m,
    )
    weights = np.abs(hybrid_shares(bodies, ports)) ** 2
    doubts = azimuth_doubts(weights @ mesh.phase_centres_m)
    return replace(mesh, warnings=(*mesh.warnings, *doubts))
