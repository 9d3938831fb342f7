"""Full-wave solutions of readers, kept on disk by the hash of everything they depend on.

They are kept without loads, which are put on when they are read, so that no key holds the loads. A
file is renamed when it is whole, so that parallel runs can share the folder; one that is damaged or
from another solver is computed again. Where nothing can be kept, a warning says so.
"""

import hashlib
import importlib.resources
import json
import os
import warnings
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import platformdirs

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.kinds import Antenna
from octant.em.reader.feeding import Feeding
from octant.em.reader.fullwave.band import NODES, solve_band
from octant.em.reader.fullwave.conductor import Conductor
from octant.em.reader.fullwave.far_field import FarField
from octant.em.reader.fullwave.loads import LoadedReader, UnloadedReader, checked_loads
from octant.em.reader.fullwave.mesh import (
    CELLS_PER_WAVELENGTH,
    FEED_GAP_M,
    WIRE_RADIUS_M,
    reader_mesh,
)
from octant.em.reader.fullwave.ported import PortedMesh
from octant.em.reader.fullwave.response import response_of, solved_reader
from octant.em.reader.fullwave.result import FullwaveResult
from octant.em.reader.fullwave.solve import solve_reader
from octant.em.reader.hybrids import with_hybrids
from octant.geometries.bodies import Body
from octant.geometries.errors import CacheWarning, ConfigError
from octant.geometries.files import whole_file
from octant.geometries.reader_body import ReaderBody

CACHE_FORMAT = 3
"""Raised when the content of a file changes, so that old files are computed again [-]."""

CACHE_VARIABLE = "OCTANT_CACHE_DIR"
"""Environment variable that names the folder of everything that Octant keeps for later runs."""

_DAMAGED = (OSError, EOFError, ValueError, KeyError, TypeError, zipfile.BadZipFile, zlib.error)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReaderSolution:
    """A full-wave solution without its currents.

    Parameters
    ----------
    ports : Matrices and powers, loads put on.
    response : Embedded realised patterns at those loads.
    """

    ports: LoadedReader
    response: ReaderResponse


def cache_folder() -> Path | None:
    """Return ``$OCTANT_CACHE_DIR``, or Octant's folder in the user's cache; None without a home."""
    if chosen := os.environ.get(CACHE_VARIABLE):
        return Path(chosen)
    folder = platformdirs.user_cache_path("octant", appauthor=False, opinion=False)
    return folder if folder.is_absolute() else None  # "~" where there is no home


def cached_responses(
    body: ReaderBody,
    antenna: Antenna,
    frequencies_hz: Sequence[float],
    *,
    gap_m: float = 0.005,
    load_ohm: npt.ArrayLike = 50.0,
    cells_per_wavelength: float = CELLS_PER_WAVELENGTH,
    wire_radius_m: float = WIRE_RADIUS_M,
    feed_gap_m: float = FEED_GAP_M,
    surroundings: Sequence[Body] = (),
    conductor: Conductor | None = None,
    metal: PortedMesh | None = None,
    hybrids: npt.NDArray[np.complex128] | None = None,
    feeding: Feeding | None = None,
    folder: Path | None = None,
    keep: bool = True,
) -> tuple[ReaderSolution, ...]:
    """Return a reader's full-wave solutions in the order of the frequencies, from disk or solved.

    A solution serves all loads. A CacheWarning says when it cannot be kept.

    Parameters
    ----------
    body, antenna : Metal and places of the antennas; kind and length of one, a dipole or monopole.
    frequencies_hz : Where solutions are wanted [Hz]; of more than ``NODES`` different ones, so
        many are solved and the others interpolated, see `octant.em.reader.fullwave.band`.
    gap_m, wire_radius_m, feed_gap_m, surroundings, conductor : Of the mesh, see `reader_mesh` [m].
    load_ohm : Impedance of source and load of every port [ohm].
    metal : Mesh of a reader of any metal, solved in place of body and antennas, whose azimuths its
        ports have; None: those are solved.
    hybrids : (n, N) how hybrids share waves among its ports [-]; None: none are there.
    feeding : What lies between the antennas and the receiver, with its own loads; None: nothing.
    cells_per_wavelength : Elements per wavelength [-].
    folder : Where solutions are kept; default: ``responses`` in `cache_folder`.
    keep : Whether solutions are read from and kept on disk.
    """
    wanted = sorted({float(f) for f in frequencies_hz})
    setup: dict[str, Any] = {
        "gap_m": float(gap_m),
        "cells_per_wavelength": float(cells_per_wavelength),
        "wire_radius_m": float(wire_radius_m),
        "feed_gap_m": float(feed_gap_m),
    }
    # An interpolated solution depends on the band that it was interpolated in.
    band = [wanted[0], wanted[-1], NODES] if len(wanted) > NODES else []
    numbers = {"band": band, "surroundings": [body_hash(b) for b in surroundings], **setup}
    if conductor is not None:
        numbers["conductor"] = asdict(conductor)
    if metal is not None:
        numbers = {"band": band, "metal": _mesh_hash(metal)}
    keys = {f: _key(body, antenna, f, numbers) for f in wanted}
    setup["surroundings"] = tuple(surroundings)
    setup["conductor"] = conductor
    loads = checked_loads(load_ohm, body.antennas)
    place = _folder(folder) if keep else None
    found = {f: _read(place, keys[f]) for f in wanted}
    missing = [f for f in wanted if found[f] is None]
    if band and missing:
        missing = wanted
    elements = {f: replace(antenna, frequency_hz=f) for f in wanted}
    if metal is not None:
        solved = _solved_metal(metal, missing, whole=bool(band))
    elif band and missing:
        solved = _solved_band(body, elements[wanted[-1]], wanted, setup)
    else:
        solved = (solved_reader(body, elements[f], **setup) for f in missing)
    for f, result in zip(missing, solved, strict=True):
        found[f] = result.unloaded
        _write(place, keys[f], result.unloaded)
    if hybrids is not None:
        found = {f: u and with_hybrids(u, hybrids) for f, u in found.items()}
    done = {
        f: loaded_solution(u, body, load_ohm=loads, feeding=feeding)
        for f, u in found.items()
        if u is not None
    }
    return tuple(done[float(f)] for f in frequencies_hz)


def loaded_solution(
    unloaded: UnloadedReader,
    body: ReaderBody,
    *,
    load_ohm: npt.ArrayLike,
    feeding: Feeding | None = None,
) -> ReaderSolution:
    """Return a solution with loads put on, and what lies behind the antennas.

    Parameters
    ----------
    unloaded : The ports without loads.
    body : Gives the antennas' azimuths.
    load_ohm, feeding : As for `cached_responses` [ohm].
    """
    ports = LoadedReader(unloaded=unloaded, load_ohm=checked_loads(load_ohm, body.antennas))
    if feeding is not None:
        ports = feeding.on(ports)
    return ReaderSolution(ports=ports, response=response_of(ports, body))


def _folder(given: Path | None) -> Path | None:
    base = cache_folder() if given is None else None
    return given if base is None else base / "responses"


def _solved_band(
    body: ReaderBody,
    antenna: Antenna,
    frequencies_hz: Sequence[float],
    setup: dict[str, Any],
) -> Iterator[FullwaveResult]:
    """Yield solutions across a band, on the mesh of the antenna's frequency."""
    mesh = reader_mesh(
        body,
        frequency_hz=antenna.frequency_hz,
        antenna="monopole" if antenna.kind == "monopole" else "dipole",
        length_m=antenna.length_m,
        **setup,
    )
    # The default loads damp what is interpolated; others are put on afterwards.
    band = solve_band(mesh, frequencies_hz, nodes=NODES)
    for frequency_hz in frequencies_hz:
        yield band.at(frequency_hz)


def _solved_metal(
    mesh: PortedMesh, frequencies_hz: Sequence[float], *, whole: bool
) -> Iterator[FullwaveResult]:
    """Yield solutions of any metal, each by itself or across a whole band."""
    if whole and frequencies_hz:
        band = solve_band(mesh, frequencies_hz, nodes=NODES)
        yield from (band.at(frequency_hz) for frequency_hz in frequencies_hz)
    else:
        yield from (solve_reader(mesh, frequency_hz=f) for f in frequencies_hz)


def _mesh_hash(mesh: PortedMesh) -> str:
    """Return the SHA-256 of a mesh's triangles, ports, plane and conductor."""
    digest = hashlib.sha256(mesh.vertices_m.tobytes() + mesh.faces.tobytes())
    for port in mesh.ports:
        digest.update(b"port" + port.tobytes())
    digest.update(str(mesh.ground).encode())
    if mesh.conductor is not None:
        digest.update(str(mesh.conductor).encode() + mesh.wire_radius_m.tobytes())
    return digest.hexdigest()


def _key(
    body: ReaderBody,
    antenna: Antenna,
    frequency_hz: float,
    numbers: dict[str, Any],
) -> str:
    """Return the SHA-256 of everything that a solution depends on, the solver included."""
    value = {
        "format": CACHE_FORMAT,
        "solver": _solver_hash(),
        "body": {
            "antennas": body.antennas,
            "antenna_radius_m": body.antenna_radius_m,
            "plate_height_m": body.plate_height_m,
            "plate_height_axis_m": body.plate_height_axis_m,
            "plate_outer_radius_m": body.plate_outer_radius_m,
            **({"plate_profile_m": body.plate_profile_m} if body.plate_profile_m else {}),
            "ground_plane_m": body.ground_plane_m,
            "ground_plane_shape": body.ground_plane_shape,
            "monopole_plane_m": body.monopole_plane_m,
            "element_azimuths_rad": body.element_azimuths_rad.tolist(),
            "plate_azimuths_rad": body.plate_azimuths_rad.tolist(),
            **({} if body.errors is None else {"errors": body.errors.as_dict()}),
        },
        "antenna": [antenna.kind, antenna.length_m, antenna.axis.tolist()],
        "frequency_hz": frequency_hz,
        **numbers,
    }
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()


def body_hash(body: Body) -> str:
    """Return the SHA-256 of a body's geometry, 64 hexadecimal digits.

    Parameters
    ----------
    body : Any body [m]; name and material do not count.
    """
    data = body.vertices_m.tobytes() + body.faces.tobytes()
    return hashlib.sha256(data).hexdigest()


def _solver_hash() -> str:
    """Return a hash of Octant's version and the solver's source, which a version may share."""
    try:
        version = metadata.version("octant")
    except metadata.PackageNotFoundError:
        version = "not installed"
    digest = hashlib.sha256(version.encode())
    sources = importlib.resources.files("octant.em.reader.fullwave").iterdir()
    for source in sorted(sources, key=lambda item: item.name):
        if source.name.endswith(".py"):
            digest.update(source.name.encode() + source.read_bytes())
    return digest.hexdigest()


def _file(folder: Path, key: str) -> Path:
    return folder / f"{key[:40]}.npz"


_ARRAYS = ("admittance_s", "heat_s", "phase_centres_m")


def _read(folder: Path | None, key: str) -> UnloadedReader | None:
    """Return the solution of a key; None when there is no file that is whole and has this key."""
    if folder is None:
        return None
    try:
        # Given a name, numpy would leave a damaged file open.
        with _file(folder, key).open("rb") as handle, np.load(handle, allow_pickle=False) as data:
            if str(data["key"]) != key:
                return None
            return UnloadedReader(
                frequency_hz=float(data["frequency_hz"]),
                shorted_v=FarField(values=data["shorted_v"]),
                unknowns=int(data["unknowns"]),
                half_space=bool(data["half_space"]),
                doubts=tuple(data["doubts"].tolist()),
                **{name: data[name] for name in _ARRAYS},
            )
    except _DAMAGED:
        return None


def _write(folder: Path | None, key: str, solution: UnloadedReader) -> None:
    if folder is None:
        return
    try:
        with whole_file(_file(folder, key)) as part:
            np.savez(
                part,
                key=np.array(key),
                frequency_hz=np.array(solution.frequency_hz),
                shorted_v=solution.shorted_v.values,
                unknowns=np.array(solution.unknowns),
                half_space=np.array(solution.half_space),
                doubts=np.array(solution.doubts, dtype=np.str_),
                **{name: getattr(solution, name) for name in _ARRAYS},
            )
    except (OSError, ConfigError) as exc:
        reason = exc if isinstance(exc, OSError) else exc.__cause__
        msg = (
            f"full-wave solutions cannot be kept in {folder} "
            f"({getattr(reason, 'strerror', None) or exc}), so each run solves them again; set "
            f"{CACHE_VARIABLE} to a folder that can be written to."
        )
        warnings.warn(msg, CacheWarning, stacklevel=3)
