"""The table ``[reader]``: the reader as one would order it from a workshop, and how it is solved.

It is also what sweeps, searches and tolerances vary: a design *is* such a table.
"""

from pathlib import PurePath
from typing import Any, Literal, TypedDict

import msgspec
import numpy as np
import numpy.typing as npt

from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.reader.feeding import Feeding
from octant.em.reader.fullwave.conductor import Conductor
from octant.em.reader.fullwave.mesh import reader_mesh
from octant.em.reader.fullwave.ported import PortedMesh
from octant.geometries._plane_geometry import FloatArray, IntArray
from octant.geometries.bodies import Body
from octant.geometries.build_errors import BuildErrors
from octant.geometries.errors import ConfigError
from octant.geometries.reader_body import GroundPlaneShape, ReaderBody, reader_body
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.study_file.quantities import (
    Antennas,
    Cells,
    Distance,
    FileName,
    Load,
    MetalConductivity,
    Part,
    PartOrZero,
    Roughness,
    SheetThickness,
)
from octant.reader_design.study_file.reader_feed import ReaderFeed
from octant.reader_design.study_file.reader_metal import Body as MetalBodies
from octant.reader_design.study_file.reader_metal import ReaderPort, hybrid_shares, metal_mesh
from octant.reader_design.study_file.room import RoomObject, Table

ReaderAntenna = Literal["dipole", "monopole"]
ReaderModel = Literal["fullwave", "rays", "isolated", "files", "metal"]
Ground = Literal["none", "infinite"]

PatternTurn = Literal["none", "each"]

OF_CONDUCTOR = ("conductivity_s_per_m", "sheet_thickness_m", "roughness_factor")
"""Keys of lossy metal."""
OF_METAL = ("bodies", "ports", "ground", "refine")
"""Keys of a reader of any metal."""
HOW_SOLVED = ("cells_per_wavelength", "response", "pattern_files", "pattern_turn", "objects")
"""Keys that do not describe what is built, but how it is solved and what stands near."""


class Feed(TypedDict):
    """How antennas stand and are fed: keyword arguments of the full-wave solver, as in `Reader`."""

    gap_m: float
    load_ohm: float
    wire_radius_m: float
    feed_gap_m: float
    surroundings: tuple[Body, ...]
    conductor: Conductor | None


class Reader(Table, frozen=True, kw_only=True):
    """A reader with bearing-sensitive antennas: table ``[reader]``.

    Parameters
    ----------
    antenna : ``dipole`` or ``monopole``.
    antenna_length_m : Length of each antenna [m]; None: half a wave (dipole) or a quarter wave
        (monopole).
    antenna_radius_m : Distance r_a of the antennas from the axis [m].
    plate_height_m : Height h_p of the plates [m]; 0 is a reader without plates.
    plate_height_axis_m : Height of the plates at the axis [m]; None: as at the rim.
    plate_profile_m : Heights of the plates at even distances between axis and outer end [m]; empty:
        their upper edge is straight.
    plate_outer_radius_m : How far the plates reach from the axis [m]; None: half of
        ``ground_plane_m``.
    ground_plane_m : Side of the ground plane, or its diameter when it is round [m].
    ground_plane_shape : ``square``, ``round`` or ``octagon``.
    antennas : Number of antennas, at least 3.
    gap_m : Lower end of a dipole, or a monopole's own plane, above the ground plane [m].
    monopole_plane_m : Side of each monopole's own plane [m]; 0: it stands on the reader's ground
        plane.
    height_m : Ground plane above the floor [m].
    load_ohm : Load of each antenna [ohm].
    line : The table ``[reader.feed]``: complex loads, matching networks, cables, multiplexer; None:
        each antenna has ``load_ohm`` at its port.
    wire_radius_m : Radius of the antennas' wire [m].
    feed_gap_m : Length of the antennas' feed [m]; 0 is a delta gap.
    cells_per_wavelength : Elements of the full-wave mesh per wavelength [-]; 14 for final figures.
    response : ``fullwave`` (method of moments), or the approximations ``rays`` and ``isolated``,
        which know neither load, wire nor feed: how the reader's own body enters. ``files``: the
        reader is given entirely by ``pattern_files``. ``metal``: it is entirely given by the tables
        ``[[reader.body]]`` and ``[[reader.port]]`` and solved by the method of moments; antenna i
        is port i.
    pattern_files : One file an antenna, measured or from another solver (FEKO .ffe, HFSS .ffd, CST
        .ffs, NEC output, MSI/Planet, CSV), in the order of the antennas and in the reader's frame
        (antenna 1 along +x).
    pattern_turn : ``none``: files as they are; ``each``: each file is that of antenna 1, with its
        main direction along +x as in MSI/Planet files, and is turned to its antenna's azimuth,
        phase and origin with it; a single file then does for all antennas.
    objects : The tables ``[[reader.object]]``: metal near the reader that rides with it, such as
        the robot's body, in the reader's frame (origin at the ground plane's centre, z up). A box
        is placed by its lowest corner: one of a x b stands in the middle at x = -a/2, y = -b/2.
        Full wave only; it must not touch the reader, and takes the material ``pec`` or ``metal``.
    bodies : The tables ``[[reader.body]]``: metal from mesh files, and antennas of strips.
    ports : The tables ``[[reader.port]]``: where that metal is fed.
    ground : ``infinite``: the plane z = 0 is infinite metal, of a reader of any metal.
    refine : Whether the triangles of mesh files are halved until ``cells_per_wavelength`` holds.
    conductivity_s_per_m : Conductivity of the reader's metal [S/m]: copper 5.8e7, aluminium 3.8e7,
        brass 1.6e7; None: it is perfect, as ``objects`` always are.
    sheet_thickness_m : Thickness of its plates [m], which counts in their losses only.
    roughness_factor : Resistance of its surface over that of a smooth one [-].
    """

    antenna: ReaderAntenna = "dipole"
    antenna_length_m: Part | None = None
    antenna_radius_m: Part = 0.10
    plate_height_m: PartOrZero = 0.08
    plate_height_axis_m: PartOrZero | None = None
    plate_profile_m: tuple[Part, ...] = ()
    plate_outer_radius_m: Part | None = None
    ground_plane_m: Part = 0.20
    ground_plane_shape: GroundPlaneShape = "square"
    antennas: Antennas = 8
    gap_m: Part = 0.005
    monopole_plane_m: PartOrZero = 0.04
    height_m: Distance = 0.3
    load_ohm: Load = 50.0
    wire_radius_m: Part = 0.0005
    feed_gap_m: PartOrZero = 0.0057
    cells_per_wavelength: Cells = 10.0
    response: ReaderModel = "fullwave"
    pattern_files: tuple[FileName, ...] = ()
    pattern_turn: PatternTurn = "none"
    objects: tuple[RoomObject, ...] = msgspec.field(default=(), name="object")
    line: ReaderFeed | None = msgspec.field(default=None, name="feed")
    bodies: tuple[MetalBodies, ...] = msgspec.field(default=(), name="body")
    ports: tuple[ReaderPort, ...] = msgspec.field(default=(), name="port")
    ground: Ground = "none"
    refine: bool = True
    conductivity_s_per_m: MetalConductivity | None = None
    sheet_thickness_m: SheetThickness = 0.001
    roughness_factor: Roughness = 1.0

    def label(self) -> str:
        """Return the human name, for example ``dipole r_a = 10 cm h_p = 8 cm``."""
        if self.response == "metal":
            return " and ".join(body.name for body in self.bodies)
        radius = f"r_a = {100.0 * self.antenna_radius_m:.4g} cm"
        if self.response != "files":
            return f"{self.antenna} {radius} h_p = {100.0 * self.plate_height_m:.4g} cm"
        names = [PurePath(file).name for file in self.pattern_files]
        return f"files {' ... '.join(dict.fromkeys(names[:1] + names[-1:]))} {radius}"

    @property
    def antenna_kind(self) -> str:
        """What the antennas are: ``dipole``, ``monopole``, or the ``response`` that says it."""
        return self.antenna if self.drawn else self.response

    @property
    def drawn(self) -> bool:
        """Whether plates, ground plane and upright antennas are what is built."""
        return self.response not in {"files", "metal"}

    @property
    def has_ports(self) -> bool:
        """Whether it is solved by the method of moments, so that its ports are known."""
        return self.response in {"fullwave", "metal"}

    def hybrids(self) -> npt.NDArray[np.complex128] | None:
        """Return (n, N) how hybrids share waves among the ports [-]; None without any."""
        if all(port.second is None for port in self.ports):
            return None
        return hybrid_shares(self.bodies, self.ports)

    def metal_mesh(self, frequency_hz: float) -> PortedMesh:
        """Return the mesh of a reader of any metal [m].

        Parameters
        ----------
        frequency_hz : Frequency that it is meshed for [Hz].
        """
        return metal_mesh(
            self.bodies,
            self.ports,
            frequency_hz=frequency_hz,
            cells_per_wavelength=self.cells_per_wavelength,
            ground=self.ground,
            refine=self.refine,
            conductor=self.conductor,
            own=lambda: self._own_metal(frequency_hz),
        )

    def _own_metal(self, frequency_hz: float) -> tuple[FloatArray, IntArray]:
        """Return ground plane and plates, fine where antennas would stand [m]."""
        feed = self.feed()
        mesh = reader_mesh(
            self.body(),
            frequency_hz=frequency_hz,
            antenna=self.antenna,
            length_m=self.element(frequency_hz).length_m,
            gap_m=self.gap_m,
            wire_radius_m=self.wire_radius_m,
            feed_gap_m=self.feed_gap_m,
            surroundings=feed["surroundings"],
            cells_per_wavelength=self.cells_per_wavelength,
        )
        return mesh.vertices_m, mesh.faces[mesh.antenna_of_face < 0]

    @property
    def conductor(self) -> Conductor | None:
        """What the metal is made of; None: it is perfect."""
        if self.conductivity_s_per_m is None:
            return None
        return Conductor(
            conductivity_s_per_m=self.conductivity_s_per_m,
            thickness_m=self.sheet_thickness_m,
            roughness_factor=self.roughness_factor,
        )

    @property
    def surroundings(self) -> tuple[Body, ...]:
        """The bodies of ``objects``, in the reader's frame [m]."""
        from octant.reader_design.study_file.bodies import object_bodies

        return object_bodies(self.objects)

    def as_dict(self) -> dict[str, Any]:
        """Return what is built, by key; the surroundings by the hashes of their bodies."""
        from octant.em.reader.cache import body_hash

        apart = (*HOW_SOLVED, *OF_METAL, *OF_CONDUCTOR, "line")
        names = [name for name in self.__struct_fields__ if name not in apart]
        values = {name: getattr(self, name) for name in names}
        if self.line is not None:
            values["feed"] = msgspec.to_builtins(self.line)
        if self.conductor is not None:
            values |= {name: getattr(self, name) for name in OF_CONDUCTOR}
        if self.response == "metal":
            values |= {name: msgspec.to_builtins(getattr(self, name)) for name in OF_METAL}
        return {**values, "surroundings": [body_hash(body) for body in self.surroundings]}

    def body(self, errors: BuildErrors | None = None) -> ReaderBody:
        """Return the metal body and the antennas' places [m], origin on the ground plane's centre.

        Parameters
        ----------
        errors : What is built less what is drawn ([m], [rad]); None: as drawn.
        """
        return reader_body(
            antenna_radius_m=self.antenna_radius_m,
            antennas=self.antennas,
            plate_height_m=self.plate_height_m,
            plate_height_axis_m=self.plate_height_axis_m,
            plate_profile_m=self.plate_profile_m,
            plate_outer_radius_m=self.plate_outer_radius_m,
            ground_plane_m=self.ground_plane_m,
            ground_plane_shape=self.ground_plane_shape,
            monopole_plane_m=self.monopole_plane_m if self.antenna == "monopole" else 0.0,
            errors=errors,
        )

    def element(self, frequency_hz: float) -> Antenna:
        """Return one antenna, vertical; its length [m] is resonant where the table gives none.

        Parameters
        ----------
        frequency_hz : Frequency [Hz].
        """
        return make_antenna(self.antenna, frequency_hz, length_m=self.antenna_length_m)

    def feed(self) -> Feed:
        """Return how the antennas stand and are fed, for the full-wave solver [m], [ohm]."""
        return Feed(
            gap_m=self.gap_m,
            load_ohm=self.load_ohm,
            wire_radius_m=self.wire_radius_m,
            feed_gap_m=self.feed_gap_m,
            surroundings=self.surroundings,
            conductor=self.conductor,
        )

    def feeding(self) -> Feeding | None:
        """Return what lies between the antennas and the receiver; None: only ``load_ohm``."""
        return None if self.line is None else self.line.feeding(self.load_ohm)

    def loads_text(self) -> str:
        """Return what the antennas are loaded with, such as ``50 ohm``."""
        if self.line is None or not self.line.words():
            return f"{self.load_ohm:g} ohm"
        return f"{self.load_ohm:g} ohm behind {self.line.words()} (reader.feed)"

    def size_m(self, frequency_hz: float) -> tuple[float, float]:
        """Return width, and height above the ground plane [m], as constraints compare them.

        Plates and antennas count in both, the ground plane in the width.

        Parameters
        ----------
        frequency_hz : Carrier, at which antennas without a length are resonant [Hz].
        """
        outer_m = self.plate_outer_radius_m or 0.0
        width_m = max(self.ground_plane_m, 2.0 * outer_m, 2.0 * self.antenna_radius_m)
        joined = self.antenna == "monopole" and self.monopole_plane_m == 0.0
        top_m = (0.0 if joined else self.gap_m) + self.element(frequency_hz).length_m
        plates_m = (self.plate_height_m, self.plate_height_axis_m or 0.0, *self.plate_profile_m)
        return width_m, max(top_m, *plates_m)

    def notes(self) -> tuple[str, ...]:
        """Return what is built otherwise than one may think, in sentences [cm].

        Monopoles' own planes that had to be shrunk; metal under or over the reader that is not in
        its middle.
        """
        return (*self._shrunk_notes(), *self._off_axis_notes())

    def _shrunk_notes(self) -> tuple[str, ...]:
        if self.antenna != "monopole" or not self.drawn:
            return ()
        fitted_m = self.body().fitted_monopole_plane_m
        if fitted_m >= self.monopole_plane_m:
            return ()
        note = (
            f"the monopoles' own planes of {100.0 * self.monopole_plane_m:.3g} cm would cut the "
            f"plates at r_a = {100.0 * self.antenna_radius_m:.3g} cm and are shrunk to "
            f"{100.0 * fitted_m:.3g} cm"
        )
        return (note,)

    def _off_axis_notes(self) -> tuple[str, ...]:
        from octant.reader_design.study_file.bodies import object_bodies

        notes = []
        for i, item in enumerate(self.objects):
            bounds_m = np.array([body.bounds_m for body in object_bodies((item,))])
            low, high = bounds_m[:, 0].min(axis=0)[:2], bounds_m[:, 1].max(axis=0)[:2]
            off_m = 0.5 * (low + high)
            reach_m = 0.5 * self.ground_plane_m
            over = bool((low < reach_m).all() and (high > -reach_m).all())
            if not over or float(np.hypot(*off_m)) <= LENGTHS.step_m:
                continue
            middle = [round(float(x), 4) for x in np.array(item.position_m[:2]) - off_m]
            notes.append(
                f"the middle of reader.object[{i}] is {100.0 * float(np.hypot(*off_m)):.3g} cm off "
                f"the reader's axis (x {100.0 * off_m[0]:+.3g} cm, y {100.0 * off_m[1]:+.3g} cm), "
                f"so the antennas differ; position_m of a {item.__struct_config__.tag} is "
                f"{item.placed_by}: [{middle[0]:g}, {middle[1]:g}, {item.position_m[2]:g}] puts it "
                "in the middle"
            )
        return tuple(notes)


def check_conductor(reader: Reader) -> None:
    """Refuse keys of metal that nothing would read.

    Parameters
    ----------
    reader : The table.
    """
    if reader.conductivity_s_per_m is None:
        for name in OF_CONDUCTOR[1:]:
            if getattr(reader, name) != getattr(Reader(), name):
                msg = (
                    f"reader.{name} is given, but without reader.conductivity_s_per_m the metal is "
                    "perfect; give that, such as 5.8e7 for copper, or leave the key out."
                )
                raise ConfigError(msg)
    elif not reader.has_ports:
        msg = (
            f"reader.conductivity_s_per_m is given, but reader.response is {reader.response!r}, "
            'which knows no metal; set reader.response = "fullwave", or leave the key out.'
        )
        raise ConfigError(msg)
