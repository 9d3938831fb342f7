"""A band of frequencies from a handful of solutions, interpolated."""

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.blocks import one_blas_thread
from octant.em.reader.fullwave._circuit import admittance_of, embedded_voltages
from octant.em.reader.fullwave.mesh import ReaderMesh
from octant.em.reader.fullwave.ported import PortedMesh
from octant.em.reader.fullwave.result import FullwaveResult
from octant.em.reader.fullwave.solve import result_of, solve_reader
from octant.geometries._checks import positive_number
from octant.geometries.errors import AntennaError

NODES = 4
"""Default number of solutions across a band [-]; enough for a few per cent of bandwidth."""
TOLERANCE, MOST_NODES = 1e-3, 40
"""Difference of S at which adaptive sampling ends [-], -60 dB; solutions that it makes at most."""
_LOOKED = 401
"""Frequencies at which adaptive sampling compares two predictions [-]."""
_AAA_RTOL, _SAME = 1e-9, 1e-12


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FullwaveBand:
    """Solutions of one mesh at several frequencies, and everything in between.

    Parameters
    ----------
    results : Solutions in order of frequency, same mesh and loads; at least two.
    weights : (k,) complex128 or None — Barycentric weights of a polynomial or a rational function
        through them, 0 for those that it does not need [-]; None: polynomials through all.
    error : Greatest difference of S that was found between a solution and what the ones before it
        had predicted at its frequency, the last time [-]; None: not looked for.
    """

    results: tuple[FullwaveResult, ...]
    weights: npt.NDArray[np.complex128] | None = None
    error: float | None = None

    def __post_init__(self) -> None:
        frequencies = self.frequencies_hz
        if len(frequencies) < 2 or not (np.diff(frequencies) > 0.0).all():
            msg = (
                f"a band has solutions at {frequencies.tolist()} Hz, but at least two of rising "
                "frequency are needed."
            )
            raise AntennaError(msg)

    @property
    def frequencies_hz(self) -> npt.NDArray[np.float64]:
        """Return (k,) the frequencies that were solved [Hz]."""
        return np.array([result.frequency_hz for result in self.results])

    def shares(self, frequency_hz: float) -> npt.NDArray[np.complex128]:
        """Return (k,) what each solution contributes at a frequency of the band [-].

        Parameters
        ----------
        frequency_hz : Frequency [Hz], from the first to the last one solved.
        """
        nodes = self.frequencies_hz
        if not nodes[0] * (1 - 1e-12) <= frequency_hz <= nodes[-1] * (1 + 1e-12):
            msg = (
                f"frequency_hz is {frequency_hz:g} Hz, but the band was solved from "
                f"{nodes[0]:g} to {nodes[-1]:g} Hz; solve a wider band."
            )
            raise AntennaError(msg)
        if self.weights is not None:
            shares: npt.NDArray[np.complex128] = _shares(
                nodes, self.weights, np.array([frequency_hz])
            )[0]
            return shares
        products = [math.prod((frequency_hz - o) / (n - o) for o in nodes if o != n) for n in nodes]
        return np.array(products, dtype=np.complex128)

    @one_blas_thread()
    def admittance_s(self, frequency_hz: float) -> npt.NDArray[np.complex128]:
        """Return (n, n) the interpolated admittances of the ports without loads [S].

        Parameters
        ----------
        frequency_hz : Frequency of the band [Hz].
        """
        both = zip(self.shares(frequency_hz), self.results, strict=True)
        s_matrix = sum(w * r.s_matrix for w, r in both)
        return admittance_of(np.asarray(s_matrix), self.results[0].load_ohm)

    @one_blas_thread()
    def at(self, frequency_hz: float) -> FullwaveResult:
        """Return the interpolated solution at a frequency of the band.

        Parameters
        ----------
        frequency_hz : Frequency [Hz], from the first to the last one solved.

        Returns
        -------
        FullwaveResult
            Matrices and currents by interpolation, patterns from the currents at that frequency;
            ``balance_error`` shows what the interpolation is worth.

        Notes
        -----
        Polynomials through all solutions, or rational functions with the poles that they have in
        common, of the scattering matrix and of the currents with all ports loaded: loads damp the
        resonances that the bare admittances have.
        """
        weights = self.shares(frequency_hz)
        first = self.results[0]
        load = first.load_ohm
        loaded = sum(
            w * np.tensordot(r.embedded_voltages_v, r.halves_a_per_m, axes=(1, 0))
            for w, r in zip(weights, self.results, strict=True)
        )
        sheet = sum(w * r.sheet_ohm for w, r in zip(weights, self.results, strict=True))
        admittance = self.admittance_s(frequency_hz)
        back = np.linalg.inv(embedded_voltages(admittance, load))
        halves = np.tensordot(back, loaded, axes=(1, 0))
        return result_of(
            first.basis,
            halves,
            admittance,
            frequency_hz=frequency_hz,
            load_ohm=load,
            sheet_ohm=np.asarray(sheet),
            port_step=first.port_step,
            phase_centres_m=first.unloaded.phase_centres_m,
            doubts=first.unloaded.doubts,
            half_space=first.unloaded.half_space,
        )


def polynomial_shares(
    nodes_hz: npt.NDArray[np.float64], frequency_hz: float
) -> npt.NDArray[np.float64]:
    """Return (k,) what values at nodes contribute to their polynomial at a frequency [-].

    Parameters
    ----------
    nodes_hz, frequency_hz : (k,) Places of the values, and where they are wanted [Hz].
    """
    return np.array(
        [math.prod((frequency_hz - o) / (n - o) for o in nodes_hz if o != n) for n in nodes_hz]
    )


def chebyshev_places_hz(low_hz: float, high_hz: float, count: int) -> npt.NDArray[np.float64]:
    """Return the extrema of a Chebyshev polynomial over a band, its ends included [Hz].

    Parameters
    ----------
    low_hz, high_hz, count : Ends of the band [Hz]; number of places, at least 2.
    """
    turn = np.cos(math.pi * np.arange(count) / (count - 1))
    places: npt.NDArray[np.float64] = 0.5 * (low_hz + high_hz) - 0.5 * (high_hz - low_hz) * turn
    return places


def _shares(
    nodes_hz: npt.NDArray[np.float64],
    weights: npt.NDArray[np.complex128],
    frequencies_hz: npt.NDArray[np.float64],
) -> npt.NDArray[np.complex128]:
    """Return (f, k) what each solution contributes at frequencies, by barycentric weights [-]."""
    off = frequencies_hz[:, None] - nodes_hz
    at = np.abs(off) <= _SAME * nodes_hz[-1]
    parts = np.where(weights == 0.0, 0.0, weights / np.where(at, 1.0, off))
    shares = parts / parts.sum(axis=1, keepdims=True)
    on = at.any(axis=1)
    shares[on] = at[on]
    return np.asarray(shares)


def _rational_weights(
    nodes_hz: npt.NDArray[np.float64], values: npt.NDArray[np.complex128]
) -> npt.NDArray[np.complex128]:
    """Return (k,) barycentric weights of the rational function that AAA finds through values.

    The entries (k, ...) have their poles in common, so that a fixed mixture of them has them all.

    Y. Nakatsukasa, O. Sete, L. N. Trefethen, SIAM J. Sci. Comput. 40 (2018) A1494.
    """
    from scipy.interpolate import AAA

    flat = values.reshape(len(values), -1)
    phases = np.random.default_rng(0).uniform(0.0, 2.0 * math.pi, flat.shape[1])
    low, high = nodes_hz[0], nodes_hz[-1]
    place = (2.0 * nodes_hz - low - high) / (high - low)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # it did not reach rtol: the error tells
        # Poles of residues near rounding do no harm, and to look for them takes scipy.stats.
        found = AAA(
            place,
            flat @ np.exp(1j * phases),
            rtol=_AAA_RTOL,
            max_terms=len(place) // 2 + 1,
            clean_up=False,
        )
    weights = np.zeros(len(place), dtype=np.complex128)
    for point, weight in zip(found.support_points, found.weights, strict=True):
        weights[int(np.abs(place - point).argmin())] = weight
    return weights


def _polynomial_weights(
    nodes_hz: npt.NDArray[np.float64], values: npt.NDArray[np.complex128]
) -> npt.NDArray[np.complex128]:
    """Return (k,) barycentric weights of the polynomial through all values."""
    del values
    place = 4.0 * nodes_hz / (nodes_hz[-1] - nodes_hz[0])  # products near 1
    apart = place[:, None] - place
    np.fill_diagonal(apart, 1.0)
    return np.asarray(1.0 / apart.prod(axis=1), dtype=np.complex128)


_MODELS = (_polynomial_weights, _rational_weights)


@one_blas_thread()
def solve_band_adaptively(
    mesh: ReaderMesh | PortedMesh,
    frequencies_hz: Sequence[float],
    *,
    tolerance: float = TOLERANCE,
    most: int = MOST_NODES,
    load_ohm: npt.ArrayLike = 50.0,
    progress: Callable[[int], object] = lambda _: None,
) -> FullwaveBand:
    """Return solutions from which those at all given frequencies follow by one function.

    Each further solution is made where the polynomial and the rational function through those so
    far differ most, until one of the two has predicted it; that one is used. Narrow bands want the
    polynomial, wide ones with resonances the rational function.

    Parameters
    ----------
    mesh, frequencies_hz, load_ohm : As for `solve_band` [Hz], [ohm].
    tolerance : Greatest difference of S that is confirmed [-]; 1e-3 is -60 dB.
    most : Solutions after which it ends all the same; ``error`` of the band then says how far off.
    progress : Called with the number of solutions.
    """
    wanted = sorted({positive_number(f, name="frequencies_hz", unit="Hz") for f in frequencies_hz})
    solved: dict[float, FullwaveResult] = {}

    def solve(place: float) -> FullwaveResult:
        solved[place] = solve_reader(mesh, frequency_hz=place, load_ohm=load_ohm)
        progress(len(solved))
        return solved[place]

    def model(
        weigh: Callable[..., npt.NDArray[np.complex128]],
    ) -> Callable[[npt.NDArray[np.float64]], npt.NDArray[np.complex128]]:
        nodes = np.array(sorted(solved))
        values = np.stack([solved[f].s_matrix for f in nodes])
        weights = weigh(nodes, values)
        return lambda at: np.asarray(np.tensordot(_shares(nodes, weights, at), values, axes=(1, 0)))

    if len(wanted) <= NODES:
        return solve_band(mesh, wanted, nodes=len(wanted), load_ohm=load_ohm)
    low, high = wanted[0], wanted[-1]
    for place in chebyshev_places_hz(low, high, NODES):
        solve(float(place))
    looked = np.linspace(low, high, _LOOKED)
    errors = [math.inf, math.inf]
    while min(errors) > tolerance and len(solved) < most:
        models = [model(weigh) for weigh in _MODELS]
        apart = np.abs(models[0](looked) - models[1](looked)).max(axis=(1, 2))
        near = np.abs(looked[:, None] - np.array(list(solved))).min(axis=1)
        new = np.where(near > 0.5 * (high - low) / most, apart, -1.0)
        place = float(looked[int(np.argmax(new))])
        guesses = [one(np.array([place]))[0] for one in models]
        found = solve(place).s_matrix
        errors = [float(np.abs(guess - found).max()) for guess in guesses]
    results = tuple(solved[f] for f in sorted(solved))
    weigh = _MODELS[int(np.argmin(errors))]
    weights = weigh(np.array(sorted(solved)), np.stack([r.s_matrix for r in results]))
    return FullwaveBand(results=results, weights=weights, error=min(errors))


def solve_band(
    mesh: ReaderMesh | PortedMesh,
    frequencies_hz: Sequence[float],
    *,
    nodes: int = NODES,
    load_ohm: npt.ArrayLike = 50.0,
    surface_impedance_ohm: npt.ArrayLike | None = None,
    symmetry: bool = True,
) -> FullwaveBand:
    """Return solutions from which those at all given frequencies follow by interpolation.

    Parameters
    ----------
    mesh : Triangles and feeds, one mesh for the whole band.
    frequencies_hz : Frequencies wanted [Hz]; their least and greatest bound the band.
    nodes : Number of solutions, at least 2; no more are made than there are frequencies.
    load_ohm : Impedance of source and load of every port [ohm].
    surface_impedance_ohm : Surface impedance of each triangle [ohm]; None: that of the mesh's
        conductor.
    symmetry : Use the rotational symmetry that the mesh has.

    Returns
    -------
    FullwaveBand
        Solutions at the extrema of a Chebyshev polynomial, the band's ends included.
    """
    wanted = sorted({positive_number(f, name="frequencies_hz", unit="Hz") for f in frequencies_hz})
    if nodes < 2 or len(wanted) < 2:
        msg = (
            f"a band of {len(wanted)} frequencies by {nodes} solutions was asked for, but at least "
            "two of each are needed; solve a single frequency directly."
        )
        raise AntennaError(msg)
    places = np.array(wanted)
    if len(wanted) > nodes:
        places = chebyshev_places_hz(wanted[0], wanted[-1], nodes)
    return FullwaveBand(
        results=tuple(
            solve_reader(
                mesh,
                frequency_hz=float(place),
                load_ohm=load_ohm,
                surface_impedance_ohm=surface_impedance_ohm,
                symmetry=symmetry,
            )
            for place in places
        )
    )
