"""Touchstone files, version 1 (``.sNp``) and 2 (``.ts``, ``.sNp``): S-matrices over frequency.

The two-port's columns run S11 S21 S12 S22; from three ports on, a row starts a line, four pairs at
most a line. Version 2 says by keywords in brackets how many ports and frequencies there are, the
reference of each port, and which half of a symmetric matrix is left out. Sources: EIA/IBIS Open
Forum, Touchstone File Format Specification, Rev. 1.1 (2002) and Version 2.0 (2009).
HFSS leaves data that are not renormalised at 50 ohm in the option line and writes what the ports
have behind each frequency, as comments ``! Port Impedance``: they are read.
"""

import math
import re
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files._lines import HERTZ, number, read_lines, refusal
from octant.em.antennas.pattern_files._touchstone_2 import is_version_2, version_2_content
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import PatternFileError, PhysicsWarning
from octant.geometries.files import write_text

NumberForm = Literal["RI", "MA", "DB"]
"""Pairs in a file: real and imaginary, magnitude and degrees, decibels and degrees."""

_PAIRS_A_LINE = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class SMatrices:
    """S-matrices over frequency.

    Parameters
    ----------
    frequencies_hz : (f,) float64 — Frequencies [Hz], ascending.
    s_matrices : (f, n, n) complex128 — S[i, j] [-]: wave out of port i for a unit wave into port j.
    reference_ohm : Reference impedance [ohm] of every port; (f, n) complex128 where they differ.
    """

    frequencies_hz: npt.NDArray[np.float64]
    s_matrices: npt.NDArray[np.complex128]
    reference_ohm: float | npt.NDArray[np.complex128] = 50.0

    def __post_init__(self) -> None:
        frequencies = frozen_array(
            self.frequencies_hz, name="frequencies_hz", shape=(None,), error=PatternFileError
        )
        count = len(frequencies)
        matrices = frozen_array(
            self.s_matrices,
            name="s_matrices",
            shape=(count, None, None),
            dtype=np.complex128,
            error=PatternFileError,
        )
        if count < 1 or matrices.shape[1] < 1 or matrices.shape[1] != matrices.shape[2]:
            msg = f"s_matrices has shape {matrices.shape}; give (frequencies, ports, ports)."
            raise PatternFileError(msg)
        if frequencies[0] < 0.0 or (np.diff(frequencies) <= 0.0).any():
            msg = "frequencies_hz must ascend from 0 Hz or more; sort them, each once."
            raise PatternFileError(msg)
        if isinstance(self.reference_ohm, np.ndarray):
            reference = frozen_array(
                self.reference_ohm,
                name="reference_ohm",
                shape=matrices.shape[:2],
                dtype=np.complex128,
                error=PatternFileError,
            )
            object.__setattr__(self, "reference_ohm", reference)
        elif not (math.isfinite(self.reference_ohm) and self.reference_ohm > 0.0):
            msg = f"reference_ohm = {self.reference_ohm} ohm; give an impedance above 0 ohm."
            raise PatternFileError(msg)
        object.__setattr__(self, "frequencies_hz", frequencies)
        object.__setattr__(self, "s_matrices", matrices)


def write_touchstone(
    path: str | Path,
    frequencies_hz: npt.ArrayLike,
    s_matrices: npt.ArrayLike,
    *,
    reference_ohm: float = 50.0,
    form: NumberForm = "RI",
) -> None:
    """Write S-matrices as a Touchstone file, version 1.

    Parameters
    ----------
    path : The file; its suffix must be ``.sNp`` with N the number of ports.
    frequencies_hz : (f,) float — Frequencies [Hz], ascending.
    s_matrices : (f, n, n) complex — S-matrices [-].
    reference_ohm : Reference impedance [ohm].
    form : {"RI", "MA", "DB"} — How numbers are written; RI comes back exactly.
    """
    path = Path(path)
    data = SMatrices(
        frequencies_hz=np.asarray(frequencies_hz, dtype=np.float64),
        s_matrices=np.asarray(s_matrices, dtype=np.complex128),
        reference_ohm=reference_ohm,
    )
    ports = data.s_matrices.shape[1]
    if path.suffix.lower() != f".s{ports}p":
        msg = f"{path} does not end in .s{ports}p, which {ports} ports need; rename it."
        raise PatternFileError(msg)
    if form not in get_args(NumberForm):
        msg = f"form {form!r} is unknown; allowed are {', '.join(get_args(NumberForm))}."
        raise PatternFileError(msg)
    lines = ["! S-matrix written by Octant", f"# Hz S {form} R {data.reference_ohm!r}"]
    for frequency_hz, matrix in zip(data.frequencies_hz, data.s_matrices, strict=True):
        rows = [matrix.T.ravel()] if ports == 2 else ([matrix.ravel()] if ports == 1 else matrix)
        head = repr(float(frequency_hz))
        for row in rows:
            for chunk in _chunks(row):
                lines.append(" ".join([head, *(_pair(value, form) for value in chunk)]).strip())
                head = ""
    write_text(path, "\n".join(lines) + "\n")


def _chunks(row: npt.NDArray[np.complex128]) -> Iterator[npt.NDArray[np.complex128]]:
    """Yield the values of one line each."""
    for begin in range(0, len(row), _PAIRS_A_LINE):
        yield row[begin : begin + _PAIRS_A_LINE]


def _pair(value: complex, form: str) -> str:
    """Return one complex number as two words."""
    first, second = float(value.real), float(value.imag)
    if form != "RI":
        first, second = abs(value), math.degrees(math.atan2(second, first))
        if form == "DB":
            first = 20.0 * math.log10(max(first, 1e-15))
    return f"{float(first)!r} {second!r}"


def read_touchstone(path: str | Path) -> SMatrices:
    """Return the S-matrices of a Touchstone file, version 1 or 2, without a two-port's noise table.

    A PhysicsWarning says when comments tell of ports that are not at the option line's reference,
    but not what they have.

    Parameters
    ----------
    path : The file; of version 1 its suffix ``.sNp`` gives the number of ports.
    """
    path = Path(path)
    if is_version_2(path):
        return _version_2(path)
    suffix = re.fullmatch(r"\.s(\d{1,3})p", path.suffix.lower())
    if not suffix or int(suffix.group(1)) < 1:
        msg = f"{path} does not end in .sNp with N ports; rename it."
        raise PatternFileError(msg)
    ports = int(suffix.group(1))
    unit_hz, form, reference_ohm, lines = _options(path)
    need = 1 + 2 * ports * ports
    frequencies: list[float] = []
    matrices: list[npt.NDArray[np.complex128]] = []
    for line, words in _records(path, lines, need, ports):
        frequency_hz = words[0] * unit_hz
        if frequencies and frequency_hz <= frequencies[-1]:
            raise refusal(path, line, f"frequency {words[0]:g} does not ascend; sort the file.")
        if frequency_hz < 0.0:
            raise refusal(path, line, f"frequency {words[0]:g} is below 0; correct it.")
        values = _complex(path, line, np.array(words[1:]).reshape(-1, 2), form)
        matrix = values.reshape(ports, ports)
        frequencies.append(frequency_hz)
        matrices.append(matrix.T if ports == 2 else matrix)
    if not frequencies:
        raise refusal(path, lines[-1][0] if lines else 1, "no frequency is in the file; add one.")
    return SMatrices(
        frequencies_hz=np.array(frequencies),
        s_matrices=np.array(matrices),
        reference_ohm=_port_impedances(path, len(frequencies), ports, reference_ohm),
    )


def _version_2(path: Path) -> SMatrices:
    """Return the S-matrices of a file of version 2."""
    content = version_2_content(path)
    ports, shape = content.ports, content.matrix_format
    rows, columns = np.indices((ports, ports)).reshape(2, -1)
    told = {"full": rows >= 0, "lower": rows >= columns, "upper": rows <= columns}[shape]
    rows, columns = rows[told], columns[told]
    if content.two_port_order == "21_12":
        rows, columns = columns, rows
    frequencies: list[float] = []
    matrices: list[npt.NDArray[np.complex128]] = []
    # unlike in version 1 a line's end means nothing
    words = [(line, token) for line, tokens in content.lines for token in tokens]
    need = 1 + 2 * len(rows)
    for begin in range(0, len(words), need):
        one = words[begin : begin + need]
        line = one[0][0]
        if len(one) < need:
            what = f"the file ends after {len(one)} of {need} numbers of the last frequency."
            raise refusal(path, words[-1][0], what)
        values = np.array([number(path, at, token) for at, token in one])
        frequency_hz = float(values[0]) * content.unit_hz
        if frequency_hz < 0.0 or (frequencies and frequency_hz <= frequencies[-1]):
            raise refusal(path, line, f"frequency {values[0]:g} does not ascend from 0; sort them.")
        matrix = np.zeros((ports, ports), dtype=np.complex128)
        found = _complex(path, line, values[1:].reshape(-1, 2), content.form)
        matrix[rows, columns] = found
        if shape != "full":
            matrix[columns, rows] = found
        frequencies.append(frequency_hz)
        matrices.append(matrix)
    if len(frequencies) != content.frequencies:
        what = f"{len(frequencies)} frequencies where {content.frequencies} are announced."
        raise refusal(path, content.lines[-1][0] if content.lines else 1, what)
    reference: float | npt.NDArray[np.complex128] = content.reference_ohm[0]
    if len(set(content.reference_ohm)) > 1:
        each = np.array(content.reference_ohm, dtype=np.complex128)
        reference = np.tile(each, (len(frequencies), 1))
    return SMatrices(
        frequencies_hz=np.array(frequencies),
        s_matrices=np.array(matrices),
        reference_ohm=reference,
    )


def _port_impedances(
    path: Path, frequencies: int, ports: int, option_ohm: float
) -> float | npt.NDArray[np.complex128]:
    """Return the impedances [ohm] of HFSS's comments, (f, n); the option line's without any."""
    blocks: list[list[float]] = []
    said, due = False, 0
    for line, raw in enumerate(read_lines(path), start=1):
        comment = raw.partition("!")[2]
        said = said or bool(re.search(r"\bnot\s+(re)?normali[sz]ed", comment, re.IGNORECASE))
        head = re.match(r"\s*Port Impedance(.*)", comment, re.IGNORECASE)
        if head:
            blocks.append([])
            due, comment = 2 * ports, head.group(1)
        if due > 0:
            words = comment.split()
            blocks[-1] += [number(path, line, word) for word in words]
            due = due - len(words) if words else 0
    if blocks and {len(block) for block in blocks} == {2 * ports}:
        table = np.array(blocks).reshape(len(blocks), ports, 2) @ np.array([1.0, 1.0j])
        if len(blocks) in (1, frequencies):
            table = np.broadcast_to(table, (frequencies, ports))
            real = float(table[0, 0].real)
            return real if real > 0.0 and (table == real).all() else np.array(table)
    if blocks or said:
        text = (
            f"{path}: comments tell of ports that are not at the reference of {option_ohm:g} ohm, "
            "but not of each port at each frequency: the S-matrices' reference is in doubt"
        )
        warnings.warn(text, PhysicsWarning, stacklevel=3)
    return option_ohm


def _options(path: Path) -> tuple[float, str, float, list[tuple[int, list[str]]]]:
    """Return unit [Hz], number form, reference [ohm] and the lines of numbers."""
    unit_hz, form, reference_ohm = 1e9, "MA", 50.0
    seen = False
    lines = []
    for line, raw in enumerate(read_lines(path), start=1):
        text = raw.split("!", 1)[0].strip()
        if text.startswith("["):
            raise refusal(path, line, "a keyword of version 2 without [Version]; add it first.")
        if text.startswith("#") and not seen:
            seen = True
            words = iter(text[1:].upper().split())
            for word in words:
                if word in HERTZ:
                    unit_hz = HERTZ[word]
                elif word in get_args(NumberForm):
                    form = word
                elif word == "R":
                    reference_ohm = number(path, line, next(words, ""))
                elif word != "S":
                    what = f"option {word[:20]!r} is not read; S-parameters as RI, MA or DB are."
                    raise refusal(path, line, what)
            if reference_ohm <= 0.0:
                raise refusal(path, line, f"reference {reference_ohm:g} ohm; give more than 0 ohm.")
        elif text and not text.startswith("#"):
            lines.append((line, text.split()))
    if not seen:
        raise refusal(path, 1, "the option line '# Hz S RI R 50' is missing; add it.")
    return unit_hz, form, reference_ohm, lines


def _records(
    path: Path, lines: Sequence[tuple[int, list[str]]], need: int, ports: int
) -> Iterator[tuple[int, list[float]]]:
    """Yield first line and numbers of every frequency, which starts a line."""
    words: list[float] = []
    start, last_hz = 0, -math.inf
    for line, tokens in lines:
        values = [number(path, line, token) for token in tokens]
        if not words:
            start = line
            if ports == 2 and len(values) == 5 and values[0] <= last_hz:
                return  # a falling frequency with five columns opens the noise table
        words += values
        if len(words) > need:
            what = f"{len(words)} numbers where one frequency of {ports} ports has {need}."
            raise refusal(path, line, what)
        if len(words) == need:
            last_hz = words[0]
            yield start, words
            words = []
    if words:
        what = f"the file ends after {len(words)} of {need} numbers of the last frequency."
        raise refusal(path, lines[-1][0], what)


def _complex(
    path: Path, line: int, pairs: npt.NDArray[np.float64], form: str
) -> npt.NDArray[np.complex128]:
    """Return complex numbers from pairs."""
    first, second = pairs.T
    if form == "DB":
        if (np.abs(first) > 1000.0).any():
            raise refusal(path, line, "an S-parameter beyond 1000 dB is impossible; correct it.")
        first = 10.0 ** (first / 20.0)
    values: npt.NDArray[np.complex128] = first + 1j * second
    if form != "RI":
        values = first * np.exp(1j * np.radians(second))
    return values
