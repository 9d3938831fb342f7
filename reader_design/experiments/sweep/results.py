"""Opening a sweep: its table, a query by parameters, and single cells with their RSS."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from octant.geometries.errors import ConfigError
from octant.reader_design.experiments.sweep.cells import SUFFIX
from octant.reader_design.experiments.sweep.table import CELLS_FOLDER, TABLE_FILE, parameter_text
from octant.reader_design.keeping.folder import case_path
from octant.reader_design.showing.netcdf import read_dataset
from octant.reader_design.study_file.errors import unknown_name

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SweepResults:
    """A sweep on disk, or a part of it: scores of all cells at hand, RSS when asked for.

    Attributes
    ----------
    folder : Folder of the sweep.
    table : A row a cell, each variable with its unit: parameters as coordinates, scores by ``cell``
        and ``surrounding``, ``status``, ``failed_because``.
    """

    folder: Path
    table: "xr.Dataset"

    def __len__(self) -> int:
        return int(self.table.sizes["cell"])

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the swept parameters."""
        return tuple(json.loads(self.table.attrs["parameters"]))

    def query(self, conditions: Mapping[str, Any]) -> "SweepResults":
        """Return the cells that fulfil all conditions, in the sweep's order; may be none.

        Parameters
        ----------
        conditions : By parameter, ``status`` or other column of one value a cell, in its unit ([m],
            [Hz], ...): a value, a tuple (least, greatest), ends included, or a list or set of
            values. A value that is itself a list stands in a list: ``[[5.0, 5.0, 3.0]]``.
        """
        chosen = np.ones(len(self), dtype=bool)
        known = [str(name) for name in self.table.variables if self._is_column(str(name))]
        for name, wanted in conditions.items():
            if name not in known:
                raise ConfigError(unknown_name("the query", name, known, what="parameter"))
            chosen &= _fulfils(self.table[name].values, wanted)
        return SweepResults(folder=self.folder, table=self.table.isel(cell=chosen))

    def _is_column(self, name: str) -> bool:
        return self.table[name].dims == ("cell",)

    def cells(self) -> "Iterator[xr.Dataset]":
        """Yield every scored cell, opened when its turn comes; all scores and RSS [W].

        ``free_rss_w`` has (distance, azimuth, antenna), ``travel_rss_w`` has (travel, antenna).
        """
        for key, status in zip(
            self.table["cell_key"].values, self.table["status"].values, strict=True
        ):
            if status == "done":
                yield read_dataset(case_path(self.folder / CELLS_FOLDER, str(key), SUFFIX))


def _fulfils(values: npt.NDArray[Any], wanted: Any) -> npt.NDArray[np.bool_]:  # noqa: ANN401
    if isinstance(wanted, tuple):
        low, high = wanted
        inside: npt.NDArray[np.bool_] = (values >= low) & (values <= high)
        return inside
    if isinstance(wanted, list | set | frozenset):
        found = np.zeros(values.shape, dtype=np.bool_)
        for one in wanted:
            found |= _equals(values, one)
        return found
    return _equals(values, wanted)


def _equals(values: npt.NDArray[Any], wanted: Any) -> npt.NDArray[np.bool_]:  # noqa: ANN401
    """Return where values equal one, numbers within the rounding of a file's text."""
    if values.dtype.kind in "UO":
        return np.asarray(values.astype(str) == parameter_text(wanted))
    return np.isclose(values.astype(np.float64), float(wanted), rtol=1e-12, atol=0.0)


def open_sweep(folder: str | Path) -> SweepResults:
    """Return a sweep that ``octant sweep`` left in a folder, finished or not; reads its table only.

    Parameters
    ----------
    folder : What was given as ``--out``.

    Examples
    --------
    >>> from octant.reader_design.experiments.sweep.results import open_sweep
    >>> sweep = open_sweep("gap-and-plane")  # doctest: +SKIP
    >>> sweep.query({"ground_plane_shape": "round", "gap_m": (0.005, 0.02)})  # doctest: +SKIP
    """
    place = Path(folder)
    if not (place / TABLE_FILE).is_file():
        msg = (
            f"{place} holds no {TABLE_FILE}; give the folder of a sweep, or let 'octant sweep "
            "STUDY --out FOLDER --merge' make the table of one that was interrupted."
        )
        raise ConfigError(msg)
    table = read_dataset(place / TABLE_FILE)
    return SweepResults(folder=place, table=table.set_coords(json.loads(table.attrs["parameters"])))
