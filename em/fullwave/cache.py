"""Solutions kept on disk under the hash of all that they follow from."""

import contextlib
import hashlib
import os
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.fullwave.basis import surface_basis
from octant.em.fullwave.far_field import current_samples
from octant.em.fullwave.mesh import ReaderMesh
from octant.em.fullwave.result import FullwaveResult
from octant.em.fullwave.solve import solve_reader

FORMAT = "octant-fullwave-1"
"""Part of every key [-]; to be raised when the solver's numbers change."""

ARRAYS = (
    "load_ohm",
    "admittance_s",
    "halves_a_per_m",
    "sheet_ohm",
    "radiated_share",
    "accepted_share",
    "lost_share",
)
"""Arrays of a solution that a file keeps [-]."""


def solution_key(
    mesh: ReaderMesh,
    *,
    frequency_hz: float | None = None,
    load_ohm: npt.ArrayLike = 50.0,
    surface_impedance_ohm: npt.ArrayLike = 0.0,
    symmetry: bool = True,
) -> str:
    """Return the hash of everything that a solution follows from.

    Parameters
    ----------
    mesh : ReaderMesh
        Triangles and feeds.
    frequency_hz : float or None
        Frequency [Hz]; None takes the one that the mesh was made for.
    load_ohm : complex or (n,) array_like
        Impedance of source and load of every port [ohm].
    surface_impedance_ohm : complex or (f,) array_like
        Surface impedance of each triangle [ohm].
    symmetry : bool
        Whether rotational symmetry may be used.

    Returns
    -------
    str
        64 hexadecimal digits.
    """
    frequency = mesh.frequency_hz if frequency_hz is None else frequency_hz
    digest = hashlib.sha256(FORMAT.encode())
    for array in (
        mesh.vertices_m,
        mesh.faces,
        mesh.antenna_of_face,
        mesh.feed_bottom_m,
        mesh.feed_top_m,
        mesh.strip_of_feed,
        np.float64(frequency),
        np.broadcast_to(np.asarray(load_ohm, dtype=np.complex128), (mesh.antennas,)),
        np.zeros(len(mesh.faces)) + np.asarray(surface_impedance_ohm, dtype=np.complex128),
        np.bool_(symmetry),
    ):
        value = np.ascontiguousarray(array)
        digest.update(f"{value.dtype.str}{value.shape}".encode())
        digest.update(value.tobytes())
    return digest.hexdigest()


def cached_solution(
    mesh: ReaderMesh,
    directory: Path | str,
    *,
    frequency_hz: float | None = None,
    load_ohm: npt.ArrayLike = 50.0,
    surface_impedance_ohm: npt.ArrayLike = 0.0,
    symmetry: bool = True,
) -> FullwaveResult:
    """Return the solution of a reader, from disk if it was solved before.

    Parameters
    ----------
    mesh : ReaderMesh
        Triangles and feeds.
    directory : Path or str
        Folder of the files; made if missing.
    frequency_hz : float or None
        Frequency [Hz]; None takes the one that the mesh was made for.
    load_ohm : complex or (n,) array_like
        Impedance of source and load of every port [ohm].
    surface_impedance_ohm : complex or (f,) array_like
        Surface impedance of each triangle [ohm].
    symmetry : bool
        Use the rotational symmetry that the mesh has.

    Returns
    -------
    FullwaveResult
        The same numbers as `solve_reader` gives, bit for bit.

    Raises
    ------
    AntennaError
        When the resistance of a load is not positive.
    GeometryError
        When a feed meets no edge, or the moment equations are singular.

    Notes
    -----
    A file is written under another name and then renamed, so any number of processes may share the
    folder. A file that cannot be read is solved and written again.
    """
    key = solution_key(
        mesh,
        frequency_hz=frequency_hz,
        load_ohm=load_ohm,
        surface_impedance_ohm=surface_impedance_ohm,
        symmetry=symmetry,
    )
    path = Path(directory) / f"{key}.npz"
    # A file may be cut short by a full disk or a killed copy; then it does not count.
    with contextlib.suppress(OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return _read(path, mesh)
    result = solve_reader(
        mesh,
        frequency_hz=frequency_hz,
        load_ohm=load_ohm,
        surface_impedance_ohm=surface_impedance_ohm,
        symmetry=symmetry,
    )
    _write(path, result)
    return result


def _write(path: Path, result: FullwaveResult) -> None:
    """Write a solution under a temporary name and rename it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=path.stem, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            np.savez(
                file,
                frequency_hz=np.float64(result.frequency_hz),
                sectors=np.int64(result.basis.sectors),
                port_step=np.int64(result.port_step),
                warnings=np.array(result.warnings, dtype=np.str_),
                **{name: getattr(result, name) for name in ARRAYS},
            )
        Path(temporary).replace(path)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def _read(path: Path, mesh: ReaderMesh) -> FullwaveResult:
    """Return the solution in a file."""
    with path.open("rb") as handle, np.load(handle, allow_pickle=False) as file:
        basis = surface_basis(mesh.vertices_m, mesh.faces, sectors=int(file["sectors"]))
        frequency_hz = float(file["frequency_hz"])
        arrays = {name: file[name] for name in ARRAYS}
        samples = current_samples(basis, arrays["halves_a_per_m"], frequency_hz=frequency_hz)
        return FullwaveResult(
            frequency_hz=frequency_hz,
            samples=samples,
            basis=basis,
            port_step=int(file["port_step"]),
            warnings=tuple(str(text) for text in file["warnings"]),
            **arrays,
        )
