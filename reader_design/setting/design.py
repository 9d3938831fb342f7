"""A reader's response: the embedded patterns of its antennas, by the model that its table names."""

import hashlib
import json
from collections.abc import Sequence
from typing import Any

from msgspec.structs import replace

from octant.em.antennas.embedded import ReaderResponse
from octant.em.blocks import one_blas_thread
from octant.em.reader.cache import ReaderSolution, cached_responses
from octant.em.reader.response import reader_response
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Radio

FULLWAVE = "fullwave"
"""The model that solves for the currents on the reader [-]."""
METAL = "metal"
"""The same for a reader of any metal [-]."""


def canonical_json(value: Any) -> str:  # noqa: ANN401  any tree of plain values
    """Return JSON text that is the same for equal values, whatever the order of their keys.

    Parameters
    ----------
    value : Mappings with text keys, sequences, text, finite numbers, booleans and None.
    """
    return json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)


def content_hash(value: Any) -> str:  # noqa: ANN401  any tree of plain values
    """Return the SHA-256 of a value's canonical JSON, as 64 hexadecimal digits.

    Parameters
    ----------
    value : As :func:`canonical_json` takes it.
    """
    return hashlib.sha256(canonical_json(value).encode()).hexdigest()


def solutions(
    reader: Reader, frequencies_hz: Sequence[float], *, cells_per_wavelength: float | None = None
) -> tuple[ReaderSolution, ...]:
    """Return the full-wave solution at each frequency, from disk where it is known.

    Parameters
    ----------
    reader : The reader.
    frequencies_hz : Frequencies [Hz]; antennas without a length are resonant at the first.
    cells_per_wavelength : Elements of the mesh per wavelength [-]; by default the reader's own.
    """
    with one_blas_thread():
        return cached_responses(
            reader.body(),
            reader.element(frequencies_hz[0]),
            frequencies_hz,
            cells_per_wavelength=cells_per_wavelength or reader.cells_per_wavelength,
            metal=reader.metal_mesh(max(frequencies_hz)) if reader.response == METAL else None,
            hybrids=reader.hybrids(),
            feeding=reader.feeding(),
            **reader.feed(),
        )


def response_at(reader: Reader, frequency_hz: float, model: str | None = None) -> ReaderResponse:
    """Return the embedded patterns of all antennas at one frequency, with the model's warnings.

    Parameters
    ----------
    reader, frequency_hz : The reader and the frequency [Hz].
    model : As ``reader.response``, which is the default.
    """
    model = model or reader.response
    if model in {FULLWAVE, METAL}:
        return solutions(reader, (frequency_hz,))[0].response
    body = reader.body()
    with one_blas_thread():
        if model == "files":
            from octant.em.antennas.from_files import reader_from_pattern_files

            each = reader.pattern_turn == "each"
            files = reader.pattern_files
            return reader_from_pattern_files(
                files * reader.antennas if each and len(files) == 1 else files,
                azimuths_rad=body.element_azimuths_rad,  # the body only places the antennas
                turns_rad=body.element_azimuths_rad if each else 0.0,
                frequency_hz=frequency_hz,
                phase_centres_m=body.element_feet_m,
                load_ohm=reader.load_ohm,
            )
        element = reader.element(frequency_hz)
        return reader_response(body, element, model=model, gap_m=reader.gap_m)


def reader_responses(reader: Reader, radio: Radio) -> tuple[ReaderResponse, ...]:
    """Return a reader's response at each frequency of a radio, in its order.

    Parameters
    ----------
    reader : The reader.
    radio : Frequencies [Hz]. At all of them the antennas have one length: the reader's, or the
        resonant one at the carrier.
    """
    cut = replace(reader, antenna_length_m=reader.element(radio.frequency_hz).length_m)
    if reader.has_ports:
        return tuple(found.response for found in solutions(cut, radio.frequencies_hz))
    return tuple(response_at(cut, f) for f in radio.frequencies_hz)
