"""Any parameters swept, each combination scored by the built-in scores or by a function."""

import inspect
import itertools
import math
import tempfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from octant.geometries.errors import ConfigError, SweepStateError
from octant.reader_design.experiments.sweep.compute import sweep_study
from octant.reader_design.experiments.sweep.results import open_sweep
from octant.reader_design.experiments.sweep.table import column
from octant.reader_design.face.reader import Reader
from octant.reader_design.face.room import Room, link_study
from octant.reader_design.face.shown import progress_of
from octant.reader_design.face.study import Study
from octant.reader_design.face.tables import Tag
from octant.reader_design.keeping.keeper import Kept, RecordCodec, map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.showing.netcdf import variable
from octant.reader_design.study_file.loading import vary
from octant.reader_design.study_file.schema import Study as StudyTables
from octant.reader_design.study_file.sweep import expanded, parameter_unit

if TYPE_CHECKING:
    import xarray as xr

Score = Callable[[Study], float | Mapping[str, float]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scorer:
    """A function that scores studies, with the study that is varied.

    Parameters
    ----------
    study, function : What is varied, and what scores it.
    code : What the function computes; its results are found again only while it is the same.
    """

    study: StudyTables
    code: str
    function: Score


@dataclass(frozen=True, slots=True, kw_only=True)
class Scored:
    """What a function returned for one combination.

    Parameters
    ----------
    scores : By name, in the function's own units [-].
    """

    scores: dict[str, float]


def scored_case(scorer: Scorer, values: dict[str, Any]) -> Scored:
    """Return the scores of one combination of values.

    Parameters
    ----------
    scorer, values : What scores it, and its values by parameter, in the unit of the key.
    """
    made = scorer.function(Study.of(vary(scorer.study, values)))
    named = dict(made) if isinstance(made, Mapping) else {"score": made}
    return Scored(scores={str(name): float(value) for name, value in named.items()})


def sweep(
    reader: Reader,
    parameters: Mapping[str, Any],
    *,
    score: Score | None = None,
    room: Room | None = None,
    tags: Sequence[Tag] = (),
    store: str | Path | None = None,
    frequency_hz: float = 2.4e9,
    channels_hz: Sequence[float] = (),
    solver: Mapping[str, Any] | None = None,
    tables: Mapping[str, Any] | None = None,
    workers: int | None = 1,
    progress: bool | Progress = True,
) -> "xr.Dataset":
    """Return the scores of every combination of parameters, with one dimension a parameter.

    NaN where a combination has no score; ``failed_because`` says why. Refuse when none has one.

    Parameters
    ----------
    reader : The reader that is varied.
    parameters : Lists of values, or ranges ``{"from": .., "to": .., "count": ..}``, by name as in
        the table ``[sweep]``: a key of the reader, or the path of one, such as ``"room.material"``.
    score : Takes each varied `Study` and returns a number, or a mapping of names to numbers; by
        default the scores of ``octant sweep``.
    room, tags : The room (free space where it is left out) and its tags.
    store : Folder in which every combination is kept: the same call again goes on where it stopped.
    frequency_hz, channels_hz : Carrier and hopping frequencies [Hz].
    solver, tables : Keys of ``[solver]``, and further tables of a study file by name.
    workers : Processes; None: one for each core. They import ``score`` from its module, and a
        script that starts them must guard its main part with ``if __name__ == "__main__"``.
    progress : False silences it.

    Examples
    --------
    >>> import octant
    >>> def top_gain(study):
    ...     pattern = study.solve(step_deg=30, progress=False).pattern
    ...     return float(abs(pattern).max())
    >>> reader = octant.Reader(response="isolated", plate_height_m=0.0)
    >>> heights = {"antenna_radius_m": [0.05, 0.08]}
    >>> octant.sweep(reader, heights, score=top_gain, progress=False)["score"].round(2).values
    array([1.28, 1.28])
    """
    given = {
        **(tables or {}),
        "solver": solver,
        "sweep": dict(parameters),
    }
    study = link_study(
        Room.free_space() if room is None else room,
        tags,
        reader,
        given,
        frequency_hz=frequency_hz,
        channels_hz=channels_hz,
    )
    if not study.sweep:
        msg = "no parameter is swept; give for example {'plate_height_m': [0.0, 0.08]}."
        raise ConfigError(msg)
    shown = progress_of(progress)
    with ExitStack() as stack:
        folder = Path(store or stack.enter_context(tempfile.TemporaryDirectory()))
        if score is None:
            sweep_study(study, folder, workers=workers, progress=shown)
            return _by_parameter(open_sweep(folder).table, study)
        swept = expanded(study.sweep)
        cases = [
            dict(zip(swept, values, strict=True)) for values in itertools.product(*swept.values())
        ]
        kept = map_cases(
            scored_case,
            cases,
            context=Scorer(study=study, code=code_of(score), function=score),
            folder=folder,
            codec=RecordCodec(Scored),
            leave_out=("Scorer.function", "Study.sweep", "Study.name"),
            workers=workers,
            progress=shown,
            label="combinations",
        )
    return _scores(kept, study)


def code_of(function: Callable[..., Any]) -> str:
    """Return what tells a function of the user's from another one: its source, or its code.

    Parameters
    ----------
    function : Any function.
    """
    try:
        return inspect.getsource(function)
    except (OSError, TypeError):
        code = getattr(function, "__code__", None)
        if code is None:
            return repr(type(function))
        return repr((code.co_code, code.co_consts, code.co_names))


def _axes(study: StudyTables) -> "dict[str, xr.Variable]":
    return {
        name: variable(
            [name], column(values), units=parameter_unit(name) or "1", long_name=f"swept: {name}"
        )
        for name, values in expanded(study.sweep).items()
    }


def _scores(kept: Sequence[Kept[Scored]], study: StudyTables) -> "xr.Dataset":
    import xarray as xr

    if all(one.record is None for one in kept):
        msg = f"no combination has a score: {kept[0].reason}"
        raise SweepStateError(msg)
    axes = _axes(study)
    shape = tuple(axis.size for axis in axes.values())
    names = dict.fromkeys(n for one in kept if one.record for n in one.record.scores)
    rows = [{} if one.record is None else one.record.scores for one in kept]
    data = {}
    for name in names:
        values = np.array([row.get(name, math.nan) for row in rows]).reshape(shape)
        data[name] = variable(list(axes), values, units="1", long_name=name, missing="no score")
    reasons = np.array([one.reason for one in kept]).reshape(shape)
    data["failed_because"] = variable(
        list(axes), reasons, units="1", long_name="why there is no score"
    )
    return xr.Dataset(data, coords=axes)


def _by_parameter(table: "xr.Dataset", study: StudyTables) -> "xr.Dataset":
    """Return a table of cells with a dimension for each parameter in place of the cell's number."""
    import xarray as xr

    axes = _axes(study)
    shape = tuple(axis.size for axis in axes.values())
    data = {}
    for name, item in table.data_vars.items():
        if "cell" not in item.dims:
            data[name] = item.variable
            continue
        moved = item.transpose("cell", ...)
        dims = [*axes, *(d for d in moved.dims if d != "cell")]
        values = moved.to_numpy().reshape(*shape, *moved.shape[1:])
        data[name] = xr.Variable(dims, values, attrs=item.attrs)
    others = {n: c.variable for n, c in table.coords.items() if "cell" not in c.dims}
    return xr.Dataset(data, coords={**others, **axes}, attrs=table.attrs)
