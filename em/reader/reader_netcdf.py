"""``reader.nc``: embedded patterns, impedances and S-matrix of a reader as netCDF."""

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.antennas.pattern_files.resample import half_turn_steps
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import PatternFileError

if TYPE_CHECKING:
    import xarray as xr


def reader_dataset(
    response: ReaderResponse,
    *,
    impedance_ohm: npt.ArrayLike | None = None,
    s_matrix: npt.ArrayLike | None = None,
    step_deg: float | None = None,
) -> "xr.Dataset":
    """Return a reader's response as a dataset with units, in the reader's own frame.

    Parameters
    ----------
    response : The patterns; stored with their phase at the reader's centre.
    impedance_ohm, s_matrix : (n,), (n, n) complex — Inputs, the others loaded [ohm]; S-matrix [-].
    step_deg : Step of theta and phi [deg], a divisor of 180; None: the response's own, exactly.
    """
    import xarray as xr

    n = response.antennas
    theta_deg = np.degrees(response.theta_rad)
    phi_deg = np.append(np.degrees(response.phi_rad), 360.0)
    if step_deg is not None:
        half_turn = half_turn_steps(step_deg)
        theta_deg = np.linspace(0.0, 180.0, half_turn + 1)
        phi_deg = np.linspace(0.0, 360.0, 2 * half_turn + 1)
        grid = np.meshgrid(np.radians(theta_deg), np.radians(phi_deg[:-1]), indexing="ij")
        pattern = np.moveaxis(response.far_field(*grid), -1, 1)
    else:
        pattern = response.pattern_at_centre
    pattern = np.concatenate((pattern, pattern[..., :1]), axis=-1)
    variables = {
        "pattern": _variable(
            ("antenna", "component", "theta", "phi"),
            pattern,
            "1",
            "embedded far field, |F|^2 = gain, phase at the reader's centre, e^{+j w t}",
        ),
        "azimuth_deg": _variable(
            ("antenna",), np.degrees(response.azimuths_rad), "degree", "azimuth of the antenna"
        ),
        "phase_centre_m": _variable(
            ("antenna", "axis"), response.phase_centres_m, "m", "place of the antenna"
        ),
        "frequency_hz": _variable((), response.frequency_hz, "Hz", "frequency"),
    }
    if impedance_ohm is not None:
        checked = frozen_array(
            impedance_ohm,
            name="impedance_ohm",
            shape=(n,),
            dtype=np.complex128,
            error=PatternFileError,
        )
        text = "input impedance, the others loaded"
        variables["impedance_ohm"] = _variable(("antenna",), checked, "ohm", text)
    if s_matrix is not None:
        checked = frozen_array(
            s_matrix, name="s_matrix", shape=(n, n), dtype=np.complex128, error=PatternFileError
        )
        text = "wave out of antenna for a unit wave into antenna_2"
        variables["s_matrix"] = _variable(("antenna", "antenna_2"), checked, "1", text)
    attributes = {
        "title": "Embedded patterns of a bearing-sensitive RFID reader",
        "Conventions": "CF-1.8",
        "frame": "the reader's own: origin at its centre, antenna 1 at azimuth 0, z up",
        "model": response.model,
        "warnings": json.dumps(list(response.warnings)),
    }
    coordinates = _coordinates(n, theta_deg, phi_deg, s_matrix is not None)
    return xr.Dataset(variables, coords=coordinates, attrs=attributes)


def _variable(
    dims: tuple[str, ...], values: npt.ArrayLike, units: str, long_name: str
) -> "xr.Variable":
    """Return a variable with units; complex numbers get a last dimension, part."""
    import xarray as xr

    array = np.asarray(values)
    if np.iscomplexobj(array):
        array, dims = np.stack((array.real, array.imag), axis=-1), (*dims, "part")
    return xr.Variable(dims, array, attrs={"units": units, "long_name": long_name})


def _coordinates(
    n: int,
    theta_deg: npt.NDArray[np.float64],
    phi_deg: npt.NDArray[np.float64],
    two: bool,
) -> dict[str, "xr.Variable"]:
    numbers = np.arange(1, n + 1)
    coordinates = {
        "theta_deg": _variable(("theta",), theta_deg, "degree", "angle from +z, upwards"),
        "phi_deg": _variable(("phi",), phi_deg, "degree", "azimuth from antenna 1 (+x')"),
        "antenna": _variable(("antenna",), numbers, "1", "number of the antenna"),
        "component": _variable(("component",), ["theta", "phi"], "1", "component of the far field"),
        "part": _variable(("part",), ["re", "im"], "1", "real or imaginary part"),
        "axis": _variable(("axis",), ["x", "y", "z"], "1", "axis of the reader's frame"),
    }
    if two:
        text = "number of the antenna that is fed"
        coordinates["antenna_2"] = _variable(("antenna_2",), numbers, "1", text)
    return coordinates


def read_reader_netcdf(path: str | Path) -> ReaderResponse:
    """Return the response that a ``reader.nc`` holds, phase referred to each antenna's place.

    Parameters
    ----------
    path : The file, of `reader_dataset` or another program: ``pattern`` on a uniform grid with
        ``theta_deg`` 0..180 and ``phi_deg`` 0..360, and ``frequency_hz``; without
        ``phase_centre_m`` it is 0, without ``azimuth_deg`` evenly spread.
    """
    import xarray as xr

    path = Path(path)
    try:
        with xr.open_dataset(path, engine="h5netcdf") as data:
            data.load()
            return _response(path, data)
    except PatternFileError:
        raise
    except (OSError, ValueError, KeyError, TypeError, RuntimeError, AttributeError) as exc:
        what = " ".join(str(exc).split())
        msg = f"{path} cannot be read as a reader.nc ({what}); give one that Octant wrote."
        raise PatternFileError(msg) from exc


def _response(path: Path, data: "xr.Dataset") -> ReaderResponse:
    for name in ("pattern", "frequency_hz", "theta_deg", "phi_deg"):
        if name not in data:
            msg = f"{path}: variable {name!r} is missing; give a reader.nc that Octant wrote."
            raise PatternFileError(msg)
    parts = data["pattern"].transpose("antenna", "component", "theta", "phi", "part").to_numpy()
    theta_deg, phi_deg = data["theta_deg"].to_numpy(), data["phi_deg"].to_numpy()
    columns = len(phi_deg) - (1 if abs(phi_deg[-1] - 360.0) < 1e-6 else 0)
    uniform = np.allclose(
        theta_deg, np.linspace(0.0, 180.0, len(theta_deg)), atol=1e-6
    ) and np.allclose(phi_deg[:columns], np.arange(columns) * 360.0 / max(columns, 1), atol=1e-6)
    if not uniform or parts.shape[1] != 2 or parts.shape[4] != 2:
        msg = f"{path}: theta_deg 0..180 and phi_deg 0..360 must be uniform; write the grid anew."
        raise PatternFileError(msg)
    pattern = (parts[..., 0] + 1j * parts[..., 1])[..., :columns]
    n = len(pattern)
    azimuths = np.arange(n) * (2.0 * math.pi / n)
    if "azimuth_deg" in data:
        azimuths = np.radians(data["azimuth_deg"].to_numpy())
    centres = np.zeros((n, 3))
    if "phase_centre_m" in data:
        centres = data["phase_centre_m"].transpose("antenna", "axis").to_numpy()
    common: dict[str, Any] = {
        "model": str(data.attrs.get("model", "file")),
        "frequency_hz": float(data["frequency_hz"]),
        "azimuths_rad": azimuths,
        "phase_centres_m": centres,
        "warnings": tuple(str(text) for text in json.loads(data.attrs.get("warnings", "[]"))),
    }
    return ReaderResponse.from_centre(pattern, **common)
