"""What ``octant reader`` prints: impedances, S-matrix and power balance as lines of text."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from octant.em.reader.fullwave.result import FullwaveResult


def port_lines(
    result: FullwaveResult,
    azimuths_rad: npt.NDArray[np.float64],
    peak_gain_dbi: npt.NDArray[np.float64],
) -> Iterator[str]:
    """Yield one line for each antenna: impedance [ohm], reflection [dB], power [%], gain [dBi].

    Parameters
    ----------
    result : FullwaveResult
        Solution.
    azimuths_rad : (n,) float64
        Azimuths of the antennas [rad].
    peak_gain_dbi : (n,) float64
        Greatest realised gain of each antenna [dBi].

    Yields
    ------
    str
        A heading, then one line an antenna.
    """
    yield (
        "antenna  azimuth [°]  input impedance [ohm]  reflection [dB]  radiated [%]  "
        "to other loads [%]  greatest gain [dBi]"
    )
    s_matrix = result.s_matrix
    returned = np.abs(np.diagonal(s_matrix)) ** 2
    coupled = (np.abs(s_matrix) ** 2).sum(axis=0) - returned
    for i, z in enumerate(result.input_impedance_ohm):
        seen = f"{z.real:.1f}{z.imag:+.1f}j"
        yield (
            f"{i + 1:>7}{np.degrees(azimuths_rad[i]):>13.1f}{seen:>23}"
            f"{10.0 * np.log10(max(returned[i], 1e-10)):>17.2f}"
            f"{100.0 * result.radiated_share[i]:>14.1f}{100.0 * coupled[i]:>20.1f}"
            f"{peak_gain_dbi[i]:>21.2f}"
        )


def s_matrix_lines(s_matrix: npt.NDArray[np.complex128]) -> Iterator[str]:
    """Yield the magnitudes of a scattering matrix [dB], a line for each receiving antenna.

    Parameters
    ----------
    s_matrix : (n, n) complex128
        Scattering matrix [-].

    Yields
    ------
    str
        A heading with the driven antennas, then the rows.
    """
    level = 20.0 * np.log10(np.maximum(np.abs(s_matrix), 1e-10))
    numbers = "".join(f"{i + 1:>8}" for i in range(len(level)))
    yield f"|S| [dB]{numbers}"
    for i, row in enumerate(level):
        yield f"{i + 1:>8}" + "".join(f"{value:>8.2f}" for value in row)


def balance_line(result: FullwaveResult) -> str:
    """Return the power balance of a solution in one sentence [%].

    Parameters
    ----------
    result : FullwaveResult
        Solution.

    Returns
    -------
    str
        Radiated against accepted power, and how symmetric the scattering matrix is.
    """
    s_matrix = result.s_matrix
    skew = float(np.abs(s_matrix - s_matrix.T).max())
    return (
        f"Power balance: radiated and accepted power differ by {100.0 * result.balance_error:.2g} "
        f"% at most; the S-matrix is symmetric within {skew:.1e}."
    )
