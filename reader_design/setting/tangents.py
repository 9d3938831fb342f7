"""What a reader's response becomes when one of its dimensions changes a little: by derivatives.

One factorised solution gives them all (`octant.em.reader.fullwave.derivatives`); whatever follows
from a response, such as a score, is differenced along the tangent, which costs no solution.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from dataclasses import replace as replaced

import numpy as np
import numpy.typing as npt
from msgspec.structs import replace

from octant.em.antennas.embedded import ReaderResponse
from octant.em.blocks import one_blas_thread
from octant.em.reader.cache import loaded_solution
from octant.em.reader.fullwave.derivatives import (
    STEP_M,
    Move,
    PortDerivative,
    along_all,
    solve_with_derivatives,
)
from octant.em.reader.fullwave.loads import UnloadedReader
from octant.em.reader.fullwave.mesh import reader_meshes
from octant.geometries.build_errors import BuildErrors, common_errors
from octant.geometries.errors import ConfigError
from octant.geometries.reader_body import ReaderBody
from octant.reader_design.setting.design import FULLWAVE
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Radio

ALONG_M = 1e-5
"""How far along the tangent what follows from a response is differenced, for a length [m]."""
ALONG_OHM = 1e-2
"""The same for a load [ohm]."""

_ERRORS = {
    "antenna_length_m": "length_m",
    "antenna_radius_m": "radial_m",
    "gap_m": "gap_m",
    "ground_plane_m": "ground_plane_m",
    "plate_height_m": "plate_height_m",
    "plate_height_axis_m": "plate_height_m",
}

PROFILE = "plate_profile_m"
"""Key of the plates' heights between axis and outer end, each with its number: ``.0`` and so on."""

FOLLOWED = (*_ERRORS, PROFILE, "load_ohm")
"""Keys of ``[reader]`` by which a response has a derivative; the mesh of others is made afresh."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tangent:
    """A reader's responses with one key a little less and a little more, all else equal.

    Parameters
    ----------
    before, after : Responses at each frequency.
    step : Half of the key's difference between them [m], [ohm].
    """

    before: tuple[ReaderResponse, ...]
    after: tuple[ReaderResponse, ...]
    step: float


def tangents(reader: Reader, radio: Radio, names: Iterable[str]) -> dict[str, Tangent]:
    """Return a full-wave reader's responses to either side of it along each of some keys.

    Parameters
    ----------
    reader, radio : The reader and its frequencies [Hz].
    names : Keys of ``[reader]`` out of `FOLLOWED`.
    """
    wanted = tuple(names)
    refuse_without_derivatives(reader, wanted)
    cut = replace(reader, antenna_length_m=reader.element(radio.frequency_hz).length_m)
    with one_blas_thread():
        each = [_at_frequency(cut, f, wanted) for f in radio.frequencies_hz]
    return {
        name: Tangent(
            before=tuple(one[name][0] for one in each),
            after=tuple(one[name][1] for one in each),
            step=ALONG_OHM if name == "load_ohm" else ALONG_M,
        )
        for name in wanted
    }


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BuildStep:
    """One way to build a reader otherwise: a little less, and a little more, of it.

    Parameters
    ----------
    before, after : Errors to either side of the drawing ([m], [rad]).
    step : Half of their difference [unit of the step].
    """

    before: BuildErrors
    after: BuildErrors
    step: float


def built_along(
    reader: Reader, radio: Radio, steps: Sequence[BuildStep], amounts: Sequence[Sequence[float]]
) -> tuple[tuple[tuple[ReaderResponse, ...], ...], ...]:
    """Return a full-wave reader's responses along the tangents of errors that antennas share.

    For each step and each of its amounts the responses at all frequencies; one solution at each.

    Parameters
    ----------
    reader, radio : The drawing and its frequencies [Hz].
    steps, amounts : In which directions, and how far along each [unit of the step].
    """
    refuse_without_derivatives(reader, ())
    cut = replace(reader, antenna_length_m=reader.element(radio.frequency_hz).length_m)
    body = reader.body()
    builds = [cut.body(errors) for one in steps for errors in (one.before, one.after)]
    widths = [one.step for one in steps]
    each = [_solved_along(cut, f, builds, widths) for f in radio.frequencies_hz]

    def response(at: int, step: int, amount: float) -> ReaderResponse:
        solution, derivatives = each[at]
        ports = derivatives[step].along(solution, amount)
        feeding = cut.feeding()
        return loaded_solution(ports, body, load_ohm=cut.load_ohm, feeding=feeding).response

    with one_blas_thread():
        return tuple(
            tuple(tuple(response(at, k, a) for at in range(len(each))) for a in amounts[k])
            for k in range(len(steps))
        )


def built_readers(
    reader: Reader, radio: Radio, steps: Sequence[BuildStep], amounts: npt.NDArray[np.float64]
) -> Iterator[tuple[ReaderResponse, ...]]:
    """Yield the responses at all frequencies of readers with any errors, to first order.

    One solution at each frequency, without symmetry, whatever the number of readers.

    Parameters
    ----------
    reader, radio : The drawing and its frequencies [Hz].
    steps : What may be off.
    amounts : (d, k) float64 — How far each of d readers is along each step [unit of the step].
    """
    refuse_without_derivatives(reader, ())
    cut = replace(reader, antenna_length_m=reader.element(radio.frequency_hz).length_m)
    body, feeding = reader.body(), reader.feeding()
    builds = [cut.body(errors) for one in steps for errors in (one.before, one.after)]
    widths = [one.step for one in steps]
    each = [_solved_along(cut, f, builds, widths, symmetry=False) for f in radio.frequencies_hz]
    for row in amounts:
        ports = [along_all(solution, derivatives, row) for solution, derivatives in each]
        yield tuple(
            loaded_solution(one, body, load_ohm=cut.load_ohm, feeding=feeding).response
            for one in ports
        )


def refuse_without_derivatives(reader: Reader, names: Iterable[str]) -> None:
    """Refuse a reader whose model has no derivatives, and keys by which it has none [-].

    Parameters
    ----------
    reader, names : The reader and keys of ``[reader]``.
    """
    if reader.response != FULLWAVE:
        msg = (
            f'reader.response is "{reader.response}", but only the full-wave solution has '
            'derivatives; give "fullwave", or search with a method without gradients.'
        )
        raise ConfigError(msg)
    for name in names:
        if name.partition(".")[0] not in FOLLOWED:
            msg = (
                f"reader.{name} has no derivative, as its mesh is made afresh for every value; "
                f"vary {', '.join(FOLLOWED)}, or search with a method without gradients."
            )
            raise ConfigError(msg)


def _at_frequency(
    reader: Reader, frequency_hz: float, names: tuple[str, ...]
) -> dict[str, tuple[ReaderResponse, ReaderResponse]]:
    """Return the responses before and after for each key."""
    lengths = [name for name in names if name != "load_ohm"]
    body = reader.body()
    builds = [moved_body(reader, name, s) for name in lengths for s in (-STEP_M, STEP_M)]
    widths = [STEP_M] * len(lengths)
    solution, derivatives = _solved_along(reader, frequency_hz, builds, widths)
    slopes = dict(zip(lengths, derivatives, strict=True))

    def response(name: str, sign: int) -> ReaderResponse:
        ports, load_ohm = solution, reader.load_ohm
        if name == "load_ohm":
            load_ohm += sign * ALONG_OHM
        else:
            ports = slopes[name].along(solution, sign * ALONG_M)
        other = replace(reader, load_ohm=load_ohm)
        done = loaded_solution(ports, body, load_ohm=load_ohm, feeding=other.feeding())
        return done.response

    return {name: (response(name, -1), response(name, 1)) for name in names}


def _solved_along(
    reader: Reader,
    frequency_hz: float,
    builds: Sequence[ReaderBody],
    widths: Sequence[float],
    *,
    symmetry: bool = True,
) -> tuple[UnloadedReader, tuple[PortDerivative, ...]]:
    """Return the drawing's ports and their derivatives; two builds to either side of it for each.

    ``widths`` are half of the differences between the two.
    """
    element, feed = reader.element(frequency_hz), reader.feed()
    drawn, *moved = reader_meshes(
        (reader.body(), *builds),
        frequency_hz=frequency_hz,
        antenna=reader.antenna,
        length_m=element.length_m,
        gap_m=feed["gap_m"],
        cells_per_wavelength=reader.cells_per_wavelength,
        wire_radius_m=feed["wire_radius_m"],
        feed_gap_m=feed["feed_gap_m"],
        surroundings=feed["surroundings"],
        conductor=feed["conductor"],
    )
    moves = [
        Move(before=before, after=after, step=width)
        for before, after, width in zip(moved[::2], moved[1::2], widths, strict=True)
    ]
    return solve_with_derivatives(drawn, moves, symmetry=symmetry)


def moved_body(reader: Reader, name: str, step_m: float) -> ReaderBody:
    """Return a reader's body with one key changed a little, as a build of the same drawing.

    Parameters
    ----------
    reader, name : The drawn reader, and a length out of `FOLLOWED`.
    step_m : Change of the key [m].
    """
    key, _, number = name.partition(".")
    error = {_ERRORS[key]: step_m} if key in _ERRORS else {"plate_height_m": step_m}
    body = reader.body(common_errors(reader.antennas, **error))
    built, drawn = body.built, reader.body().built
    if key.startswith("plate_"):
        profiles = drawn.plate_profiles_m.copy()
        if key == PROFILE:
            profiles[:, int(number)] += step_m
            ends = drawn.plate_rim_heights_m, drawn.plate_axis_height_m
            built = replaced(built, plate_rim_heights_m=ends[0], plate_axis_height_m=ends[1])
        built = replaced(built, plate_profiles_m=profiles)
    if name == "plate_height_m" and reader.plate_height_axis_m is not None:
        built = replaced(built, plate_axis_height_m=drawn.plate_axis_height_m)
    elif name == "plate_height_axis_m":
        built = replaced(built, plate_rim_heights_m=drawn.plate_rim_heights_m)
    elif name == "ground_plane_m" and reader.plate_outer_radius_m is None:
        built = replaced(built, plate_reaches_m=drawn.plate_reaches_m + 0.5 * step_m)
    return replaced(body, built=built)
