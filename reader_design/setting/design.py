"""One reader design: the numbers that describe it, its body and its antennas' response."""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, TypedDict

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.reader.cache import ReaderSolution, body_hash, cached_responses
from octant.em.reader.fullwave.mesh import CELLS_PER_WAVELENGTH, FEED_GAP_M, WIRE_RADIUS_M
from octant.em.reader.response import reader_response
from octant.geometries.bodies import Body
from octant.geometries.build_errors import BuildErrors
from octant.geometries.reader_body import GroundPlaneShape, ReaderBody, reader_body
from octant.reader_design.study_file.bodies import object_bodies
from octant.reader_design.study_file.schema import Reader, Study

FULLWAVE = "fullwave"
"""The model that solves for the currents on the reader [-]."""


class Feed(TypedDict):
    """How antennas stand and are fed, as keyword arguments of the full-wave solver.

    Attributes
    ----------
    gap_m : float
        Lower end of a dipole, or a monopole's own plane, above the ground plane [m].
    load_ohm : float
        Load of each antenna [ohm].
    wire_radius_m : float
        Radius of the wire [m].
    feed_gap_m : float
        Length of the feed [m].
    surroundings : tuple of Body
        Metal near the reader [m].
    """

    gap_m: float
    load_ohm: float
    wire_radius_m: float
    feed_gap_m: float
    surroundings: tuple[Body, ...]


def canonical_json(value: Any) -> str:  # noqa: ANN401  any tree of plain values
    """Return JSON text that is the same for equal values, whatever the order of their keys.

    Parameters
    ----------
    value : object
        Mappings with text keys, sequences, text, finite numbers, booleans and None.

    Returns
    -------
    str
        Keys sorted, no spaces, floats with the digits that identify them.

    Raises
    ------
    TypeError, ValueError
        When a value is of another type, or a number is not finite.
    """
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def content_hash(value: Any) -> str:  # noqa: ANN401  any tree of plain values
    """Return the SHA-256 of a value's canonical JSON, as 64 hexadecimal digits.

    Parameters
    ----------
    value : object
        As :func:`canonical_json` takes it.

    Returns
    -------
    str
        The same for equal values on every machine.

    Raises
    ------
    TypeError, ValueError
        As :func:`canonical_json`.
    """
    return hashlib.sha256(canonical_json(value).encode()).hexdigest()


@dataclass(frozen=True, slots=True, kw_only=True)
class ReaderDesign:
    """A bearing-sensitive reader as one would order it from a workshop.

    Attributes
    ----------
    antenna : str
        ``dipole`` or ``monopole``.
    antenna_length_m : float or None
        Length of each antenna [m]; None: half a wave (dipole) or a quarter wave (monopole).
    antenna_radius_m : float
        Distance r_a of the antennas from the axis [m].
    plate_height_m : float
        Height h_p of the plates at the rim [m]; 0: no plates.
    plate_height_axis_m : float or None
        Height of the plates at the axis [m]; None: as at the rim.
    plate_outer_radius_m : float or None
        How far the plates reach from the axis [m]; None: half of ``ground_plane_m``.
    ground_plane_m : float
        Side of the ground plane, or its diameter when round [m].
    ground_plane_shape : str
        ``square``, ``round`` or ``octagon``.
    antennas : int
        Number of antennas, at least 3.
    gap_m : float
        Lower end of a dipole, or a monopole's own plane, above the ground plane [m]; the model
        ``rays`` puts monopoles on the ground plane itself.
    monopole_plane_m : float
        Side of each monopole's own plane [m]; 0: it stands on the reader's ground plane.
    height_m : float
        Ground plane above the floor [m].
    load_ohm : float
        Load of each antenna [ohm].
    wire_radius_m : float
        Radius of the antennas' wire [m].
    feed_gap_m : float
        Length of the antennas' feed [m]; 0 is a delta gap.
    surroundings : tuple of Body
        Metal near the reader, such as the robot, in the reader's frame [m]; full wave only.
    """

    antenna: str
    antenna_length_m: float | None = None
    antenna_radius_m: float
    plate_height_m: float
    plate_height_axis_m: float | None = None
    plate_outer_radius_m: float | None = None
    ground_plane_m: float
    ground_plane_shape: GroundPlaneShape
    antennas: int
    gap_m: float
    monopole_plane_m: float
    height_m: float
    load_ohm: float
    wire_radius_m: float = WIRE_RADIUS_M
    feed_gap_m: float = FEED_GAP_M
    surroundings: tuple[Body, ...] = ()

    def label(self) -> str:
        """Return the design's human name, lengths in [cm], e.g. ``dipole r_a = 10 cm h_p = 8 cm``.

        Returns
        -------
        str
            Antenna, r_a and h_p; other parameters are those of the study.
        """
        return (
            f"{self.antenna} r_a = {100.0 * self.antenna_radius_m:.4g} cm "
            f"h_p = {100.0 * self.plate_height_m:.4g} cm"
        )

    def as_dict(self) -> dict[str, Any]:
        """Return all parameters by name, each in the unit that its name carries ([m], [ohm], [-]).

        Returns
        -------
        dict
            Plain values, as :func:`content_hash` takes them.
        """
        values = asdict(replace(self, surroundings=()))
        return {**values, "surroundings": [body_hash(body) for body in self.surroundings]}

    def key(self) -> str:
        """Return the content hash of the design, 64 hexadecimal digits.

        Returns
        -------
        str
            Equal designs have equal keys on every machine.
        """
        return content_hash(self.as_dict())

    def body(self, errors: BuildErrors | None = None) -> ReaderBody:
        """Return the reader's metal body and element places [m].

        Parameters
        ----------
        errors : BuildErrors or None
            What is built less what is drawn ([m], [rad]); None: as drawn.

        Returns
        -------
        ReaderBody
            In the reader frame, origin at the centre of the ground plane's upper side.

        Raises
        ------
        GeometryError
            When the design cannot be built.
        """
        return reader_body(
            antenna_radius_m=self.antenna_radius_m,
            antennas=self.antennas,
            plate_height_m=self.plate_height_m,
            plate_height_axis_m=self.plate_height_axis_m,
            plate_outer_radius_m=self.plate_outer_radius_m,
            ground_plane_m=self.ground_plane_m,
            ground_plane_shape=self.ground_plane_shape,
            monopole_plane_m=self.monopole_plane_m if self.antenna == "monopole" else 0.0,
            errors=errors,
        )

    def element(self, frequency_hz: float) -> Antenna:
        """Return one antenna of the reader, vertical, at a frequency [Hz].

        Parameters
        ----------
        frequency_hz : float
            Frequency [Hz].

        Returns
        -------
        Antenna
            Its length in [m] is the design's, or resonant where the design gives none.

        Raises
        ------
        AntennaError
            When kind, length or frequency cannot be used.
        """
        return make_antenna(self.antenna, frequency_hz, length_m=self.antenna_length_m)

    def response(
        self,
        frequency_hz: float,
        model: str,
        *,
        cells_per_wavelength: float = CELLS_PER_WAVELENGTH,
    ) -> ReaderResponse:
        """Return the embedded patterns of all antennas at a frequency [Hz].

        Parameters
        ----------
        frequency_hz : float
            Frequency [Hz].
        model : str
            ``fullwave``, ``rays`` or ``isolated``; see
            :func:`octant.em.reader.response.reader_response` for the two approximations.
        cells_per_wavelength : float
            Elements of the full-wave mesh per wavelength [-].

        Returns
        -------
        ReaderResponse
            With the model's warnings.

        Raises
        ------
        GeometryError, AntennaError
            When the design cannot be built or the model cannot take it.
        """
        if model == FULLWAVE:
            cells = cells_per_wavelength
            return self.solutions((frequency_hz,), cells_per_wavelength=cells)[0].response
        return reader_response(
            self.body(),
            self.element(frequency_hz),
            model=model,
            gap_m=self.gap_m,
        )

    def solutions(
        self,
        frequencies_hz: Sequence[float],
        *,
        cells_per_wavelength: float = CELLS_PER_WAVELENGTH,
    ) -> tuple[ReaderSolution, ...]:
        """Return the full-wave solution at each frequency [Hz], from disk where it is known.

        Parameters
        ----------
        frequencies_hz : sequence of float
            Frequencies [Hz]; antennas without a length are resonant at the first.
        cells_per_wavelength : float
            Elements of the mesh per wavelength [-].

        Returns
        -------
        tuple of ReaderSolution
            Patterns, matrices and powers.

        Raises
        ------
        GeometryError, AntennaError
            When the design cannot be built, meshed or solved.
        """
        from threadpoolctl import threadpool_limits

        # LAPACK's factors of a matrix depend on the number of threads in their last bits; solutions
        # are kept on disk and must not depend on who made them.
        with threadpool_limits(limits=1, user_api="blas"):
            return cached_responses(
                self.body(),
                self.element(frequencies_hz[0]),
                frequencies_hz,
                cells_per_wavelength=cells_per_wavelength,
                **self.feed(),
            )

    def feed(self) -> Feed:
        """Return how the antennas stand and are fed, as the full-wave solver takes it [m], [ohm].

        Returns
        -------
        Feed
            Keyword arguments of the solver.
        """
        return Feed(
            gap_m=self.gap_m,
            load_ohm=self.load_ohm,
            wire_radius_m=self.wire_radius_m,
            feed_gap_m=self.feed_gap_m,
            surroundings=self.surroundings,
        )

    def notes(self) -> tuple[str, ...]:
        """Return what a reader of the results must know about how the design was read, in [cm].

        Returns
        -------
        tuple of str
            For monopoles, that their own plane had to be shrunk to fit between the plates.
        """
        if self.antenna != "monopole":
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


def design_of(reader: Reader) -> ReaderDesign:
    """Return the design that a study's table ``[reader]`` describes; lengths in [m].

    Parameters
    ----------
    reader : Reader
        The table; ``response`` and ``cells_per_wavelength`` say how to compute, not what to
        build, and are left out.

    Returns
    -------
    ReaderDesign
        With every key of the table.
    """
    return ReaderDesign(
        antenna=reader.antenna,
        antenna_length_m=reader.antenna_length_m,
        antenna_radius_m=reader.antenna_radius_m,
        plate_height_m=reader.plate_height_m,
        plate_height_axis_m=reader.plate_height_axis_m,
        plate_outer_radius_m=reader.plate_outer_radius_m,
        ground_plane_m=reader.ground_plane_m,
        ground_plane_shape=reader.ground_plane_shape,
        antennas=reader.antennas,
        gap_m=reader.gap_m,
        monopole_plane_m=reader.monopole_plane_m,
        height_m=reader.height_m,
        load_ohm=reader.load_ohm,
        wire_radius_m=reader.wire_radius_m,
        feed_gap_m=reader.feed_gap_m,
        surroundings=object_bodies(reader.objects),
    )


def design_responses(study: Study, design: ReaderDesign) -> tuple[ReaderResponse, ...]:
    """Return a design's response at each frequency of a study [Hz].

    Parameters
    ----------
    study : Study
        Frequencies [Hz] and the model of the reader.
    design : ReaderDesign
        The reader.

    Returns
    -------
    tuple of ReaderResponse
        In the order of ``study.radio.frequencies_hz``. At all of them the antennas have one
        length: the design's, or the resonant one at the carrier.

    Raises
    ------
    GeometryError, AntennaError
        When the design cannot be built.
    PatternFileError
        When ``reader.pattern_files`` cannot be read.
    """
    cut = replace(design, antenna_length_m=design.element(study.radio.frequency_hz).length_m)
    model, frequencies = study.reader.response, study.radio.frequencies_hz
    if model == "files":
        return tuple(_response_of_files(study, design, f) for f in frequencies)
    if model != FULLWAVE:
        return tuple(cut.response(f, model) for f in frequencies)
    cells = study.reader.cells_per_wavelength
    solutions = cut.solutions(frequencies, cells_per_wavelength=cells)
    return tuple(solution.response for solution in solutions)


def _response_of_files(study: Study, design: ReaderDesign, frequency_hz: float) -> ReaderResponse:
    """Return the response that a study gives by pattern files; the body only places antennas."""
    from octant.em.antennas.from_files import reader_from_pattern_files

    body = design.body()
    return reader_from_pattern_files(
        study.reader.pattern_files,
        azimuths_rad=body.element_azimuths_rad,
        frequency_hz=frequency_hz,
        phase_centres_m=body.element_feet_m,
        load_ohm=design.load_ohm,
    )


def response_inputs(study: Study) -> dict[str, object]:
    """Return what a response depends on besides its design and frequency, for content hashes.

    Parameters
    ----------
    study : Study
        The study.

    Returns
    -------
    dict
        Model, mesh density and the hashes of the pattern files' contents.
    """
    return {
        "response": study.reader.response,
        "cells_per_wavelength": study.reader.cells_per_wavelength,
        "pattern_files": [
            hashlib.sha256(Path(file).read_bytes()).hexdigest()
            for file in study.reader.pattern_files
        ],
    }
