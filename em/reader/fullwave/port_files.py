"""Touchstone files at a reader's ports: what its antennas are loaded with, and its own network."""

from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.pattern_files.touchstone import SMatrices, read_touchstone
from octant.em.reader.fullwave._circuit import admittance_of
from octant.em.reader.fullwave.feeds import REFERENCE_OHM, renormalised
from octant.geometries.errors import PatternFileError

ComplexArray = npt.NDArray[np.complex128]

LEAST_APART = 0.01
"""Coupling [-] between the loads of one file, S off the diagonal, up to which they count as apart:
-40 dB."""
_SAME_SHARE = 1e-9


def loads_of_file(path: str | Path, frequency_hz: float, *, ports: int) -> ComplexArray:
    """Return the impedances of a Touchstone file that a reader's ports are loaded with, (n,) [ohm].

    Parameters
    ----------
    path : File of one port, which then loads all, or of n ports that are not coupled.
    frequency_hz : Frequency [Hz]; between those of the file S is interpolated linearly.
    ports : Number n of the reader's ports.
    """
    data = read_touchstone(path)
    s, reference = _at(Path(path), data, frequency_hz)
    given = len(s)
    if given not in {1, ports}:
        msg = f"{path} has {given} ports, but 1 or {ports} are needed to load a reader's {ports}."
        raise PatternFileError(msg)
    apart = np.abs(s - np.diag(np.diagonal(s)))
    if apart.max() > LEAST_APART:
        msg = (
            f"{path} couples its ports ({20.0 * np.log10(apart.max()):.0f} dB), but loads stand "
            "apart; give files of single ports, or the reader's own network as such."
        )
        raise PatternFileError(msg)
    reflection = np.diagonal(s)
    if (np.abs(1.0 - reflection) < _SAME_SHARE).any():
        msg = f"{path} is an open end at {frequency_hz:.6g} Hz; a load takes power."
        raise PatternFileError(msg)
    loads: ComplexArray = (reference.conj() + reflection * reference) / (1.0 - reflection)
    if (loads.real <= 0.0).any():
        msg = (
            f"{path} has the resistance {loads.real.min():.3g} ohm at {frequency_hz:.6g} Hz, but a "
            "load takes power: it must be above 0 ohm."
        )
        raise PatternFileError(msg)
    return np.broadcast_to(loads, (ports,)).copy()


def reflection_of_file(path: str | Path, frequency_hz: float) -> complex:
    """Return the reflection of a Touchstone file of one port at `REFERENCE_OHM` [-].

    Parameters
    ----------
    path, frequency_hz : The file; between its frequencies S is interpolated linearly [Hz].
    """
    s = _of_ports(path, frequency_hz, ports=1, what="an off-state load has one")
    return complex(s[0, 0])


def two_port_of_file(path: str | Path, frequency_hz: float) -> ComplexArray:
    """Return the S-matrix (2, 2) of a Touchstone file of a passive two-port at `REFERENCE_OHM` [-].

    Parameters
    ----------
    path : The file; its first port is at the antenna.
    frequency_hz : Frequency [Hz]; between those of the file S is interpolated linearly.
    """
    s = _of_ports(path, frequency_hz, ports=2, what="a network between antenna and receiver has 2")
    apart = abs(s[0, 1] - s[1, 0])
    if apart > LEAST_APART:
        msg = (
            f"{path} passes more one way than the other (S12 and S21 differ by {apart:.2g} at "
            f"{frequency_hz:.6g} Hz), but patterns hold for both ways; give what lies before an "
            "amplifier, and the amplifier's noise as sensor.noise_figure_db."
        )
        raise PatternFileError(msg)
    return s


def _of_ports(path: str | Path, frequency_hz: float, *, ports: int, what: str) -> ComplexArray:
    """Return a file's S-matrix at `REFERENCE_OHM`; refuse other numbers of ports, and gain."""
    s, reference = _at(Path(path), read_touchstone(path), frequency_hz)
    if len(s) != ports:
        msg = f"{path} has {len(s)} ports, but {what}; give another file."
        raise PatternFileError(msg)
    found = renormalised(s, reference, np.full(ports, REFERENCE_OHM + 0j))
    greatest = float(np.linalg.norm(found, 2))
    if greatest > 1.0 + LEAST_APART:
        msg = (
            f"{path} gives out more than it is given at {frequency_hz:.6g} Hz (up to "
            f"{20.0 * np.log10(greatest):.2g} dB), but what lies between antenna and receiver is "
            "passive here; give it without amplifiers."
        )
        raise PatternFileError(msg)
    return found


def network_of_file(path: str | Path, frequency_hz: float, *, ports: int) -> ComplexArray:
    """Return the admittance matrix of a Touchstone file of a reader's ports, (n, n) [S].

    Parameters
    ----------
    path : File of n ports, measured or from another solver.
    frequency_hz : Frequency [Hz]; between those of the file S is interpolated linearly.
    ports : Number n of the reader's ports.
    """
    data = read_touchstone(path)
    s, reference = _at(Path(path), data, frequency_hz)
    if len(s) != ports:
        msg = f"{path} has {len(s)} ports, but the reader has {ports} antennas; give its own file."
        raise PatternFileError(msg)
    return admittance_of(s, reference)


def _at(path: Path, data: SMatrices, frequency_hz: float) -> tuple[ComplexArray, ComplexArray]:
    """Return S (n, n) and the ports' references (n,) [ohm] at a frequency of the file's band."""
    given = data.frequencies_hz
    slack_hz = _SAME_SHARE * frequency_hz
    if not given[0] - slack_hz <= frequency_hz <= given[-1] + slack_hz:
        msg = (
            f"{path} goes from {given[0]:.6g} to {given[-1]:.6g} Hz, but {frequency_hz:.6g} Hz is "
            "needed; give a file of that band."
        )
        raise PatternFileError(msg)
    high = int(np.clip(np.searchsorted(given, frequency_hz), 1, max(len(given) - 1, 1)))
    low = high - 1
    if len(given) == 1:
        low = high = 0
    span = float(given[high] - given[low])
    share = 0.0 if span == 0.0 else float(np.clip((frequency_hz - given[low]) / span, 0.0, 1.0))
    s = (1.0 - share) * data.s_matrices[low] + share * data.s_matrices[high]
    reference = np.broadcast_to(
        np.asarray(data.reference_ohm, dtype=np.complex128), data.s_matrices.shape[:2]
    )
    if share not in {0.0, 1.0} and (reference[low] != reference[high]).any():
        msg = (
            f"{path} has other references at {given[low]:.6g} and {given[high]:.6g} Hz, between "
            "which nothing is interpolated; save it renormalised to 50 ohm."
        )
        raise PatternFileError(msg)
    return s, reference[high if share == 1.0 else low].copy()
