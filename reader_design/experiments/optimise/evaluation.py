"""One evaluation of the search: a design's scores at each distance, or why it has none."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import ConfigError, OctantError, SweepStateError
from octant.geometries.tolerances import LENGTHS
from octant.reader_design.experiments.optimise.space import key_value, with_values
from octant.reader_design.keeping.keeper import RecordCodec, map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.workers import Crew
from octant.reader_design.setting.design import reader_responses
from octant.reader_design.setting.samples import free_points_m, grid_azimuths_rad, sample_rss_w
from octant.reader_design.setting.scores import score_rss
from octant.reader_design.setting.setting import Sampling, Setting, build_setting
from octant.reader_design.setting.tangents import refuse_without_derivatives, tangents
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Study

FloatArray = npt.NDArray[np.float64]

LEFT_OUT = (
    "Setting.layout",
    "Setting.notes",
    "Setting.map_z_m",
    *(
        f"Study.{table}"
        for table in (
            "name", "seed", "sweep", "scoring", "choice", "map", "mission", "sensor", "track",
            "dock", "optimise", "tolerance", "layouts", "report",
        )
    ),
)  # fmt: skip
"""What cannot change an evaluation, so that its key does not contain it: of ``[optimise]`` the
bench holds distances and limits; of the mission only the first tag matters."""

ARRAYS = ("right_share", "margin_db", "bearing_error_deg", "front_to_back_db", "level_w")
"""Scores that an evaluation holds for each distance."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluation:
    """What is known of one design; the arrays are empty for a design without scores.

    Attributes
    ----------
    design : The design.
    reason : Why it is infeasible; empty when it is not.
    footprint_m, height_m : Ground plane's size; height of plates and antennas above it [m].
    right_share : (d,) float64 — Share of directions whose strongest antenna is the nearest [-].
    margin_db : (d,) float64 — Worst lead of the facing antenna over its neighbours [dB].
    bearing_error_deg : (d,) float64 — Error of the vector sum, rms [deg].
    front_to_back_db : (d,) float64 — Facing antenna over the opposite one, mean [dB].
    level_w : (d,) float64 — RSS of the strongest antenna, mean over azimuth [W].
    notes : Warnings of the reader's model.
    """

    design: Reader
    reason: str = ""
    footprint_m: float
    height_m: float
    right_share: FloatArray
    margin_db: FloatArray
    bearing_error_deg: FloatArray
    front_to_back_db: FloatArray
    level_w: FloatArray
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        count = np.size(self.level_w)
        for name in ARRAYS:
            array = frozen_array(
                getattr(self, name), name=name, shape=(count,), error=SweepStateError
            )
            object.__setattr__(self, name, array)

    @property
    def feasible(self) -> bool:
        """Whether the design can be built within the limits and has scores."""
        return not self.reason


@dataclass(frozen=True, slots=True, kw_only=True)
class SlopeCase:
    """A design, and the keys of ``[reader]`` by which its scores are differentiated.

    Attributes
    ----------
    design : The design.
    names : (p,) — The keys.
    """

    design: Reader
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Slopes:
    """Derivatives of the scores of an `Evaluation` by keys of ``[reader]``, per metre or ohm.

    Attributes
    ----------
    right_share, margin_db, bearing_error_deg, front_to_back_db, level_w : (p, d) float64 — By key
        and distance [unit of the score per m or ohm].
    footprint_m, height_m : (p,) float64 — Of the sizes [m per m or ohm].
    """

    right_share: FloatArray
    margin_db: FloatArray
    bearing_error_deg: FloatArray
    front_to_back_db: FloatArray
    level_w: FloatArray
    footprint_m: FloatArray
    height_m: FloatArray

    def __post_init__(self) -> None:
        count = len(self.height_m)
        for name in (*ARRAYS, "footprint_m", "height_m"):
            shape: tuple[int | None, ...] = (count, None) if name in ARRAYS else (count,)
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=SweepStateError)
            object.__setattr__(self, name, array)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bench:
    """Where designs are evaluated: tag and reader in free space.

    Attributes
    ----------
    setting, reference : The room, and the id of its only tag that is used.
    distances_m : Horizontal distances of the tag [m].
    footprint_m, height_m : Greatest size of the ground plane; of plates and antennas above it [m].
    """

    setting: Setting
    reference: str
    distances_m: tuple[float, ...]
    footprint_m: float
    height_m: float

    @property
    def study(self) -> Study:
        """The study, with its table ``[optimise]``."""
        return self.setting.study


def bench(study: Study) -> Bench:
    """Return the bench of a study, whose response must follow the design.

    Parameters
    ----------
    study : With a table ``[optimise]`` and a tag.
    """
    if study.optimise is None:
        msg = "the study has no table [optimise], but a search needs one; add it."
        raise ConfigError(msg)
    if not study.reader.drawn:
        msg = (
            f"reader.response is {study.reader.response!r}, but a search needs a model that "
            'follows the design; give "fullwave", "rays" or "isolated".'
        )
        raise ConfigError(msg)
    if study.optimise.method == "gradient":
        refuse_without_derivatives(study.reader, study.optimise.parameters.given())
    setting, table = build_setting(study, sampling=Sampling()), study.optimise
    return Bench(
        setting=setting,
        reference=setting.reference_tag.id,
        distances_m=tuple(table.distances_m),
        footprint_m=table.footprint_m,
        height_m=table.height_m,
    )


def rss_over_azimuth(
    place: Setting, design: Reader, distances_m: Sequence[float]
) -> tuple[FloatArray, FloatArray, FloatArray, tuple[str, ...]]:
    """Return (RSS [W], azimuths of the tag [rad], of the antennas [rad], the model's warnings).

    RSS has the axes distance, azimuth of the tag in the reader frame, antenna.

    Parameters
    ----------
    place : The room, of which the reference tag's height and antenna are used [m].
    design : The reader.
    distances_m : Horizontal distances of the tag [m].
    """
    responses = reader_responses(design, place.study.radio)
    rss, azimuths, elements = _rss_of(place, responses, distances_m)
    notes = dict.fromkeys((*design.notes(), *(w for r in responses for w in r.warnings)))
    return rss, azimuths, elements, tuple(notes)


def _rss_of(
    place: Setting, responses: tuple[ReaderResponse, ...], distances_m: Sequence[float]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return RSS [W] and azimuths of the tag and of the antennas [rad] of given responses."""
    elements = np.asarray(responses[0].azimuths_rad, dtype=np.float64)
    tag = place.reference_tag
    link = place.with_responses(responses).free_link(tag)
    azimuths = grid_azimuths_rad(elements.size, place.sampling.free_azimuths)
    origin = tag.position_m[:2]
    rss = sample_rss_w(link, origin + free_points_m(distances_m), origin, azimuths)
    return rss, azimuths, elements


def evaluate(place: Bench, design: Reader) -> Evaluation:
    """Return the scores of a design, or why it is infeasible; beyond the limits none is solved.

    Parameters
    ----------
    place, design : Where it is evaluated, and the design.
    """
    width_m, height_m = design.size_m(place.study.radio.frequency_hz)
    reason = _beyond_limits(place, width_m, height_m)
    scores: dict[str, FloatArray] = {name: np.zeros(0) for name in ARRAYS}
    notes: tuple[str, ...] = ()
    if not reason:
        try:
            scores, notes = _scores(place, design)
        except OctantError as exc:
            reason = str(exc)
    return Evaluation(
        design=design,
        reason=reason,
        footprint_m=width_m,
        height_m=height_m,
        notes=notes,
        **scores,
    )


def kept_evaluations(
    place: Bench,
    designs: Sequence[Reader],
    folder: Path,
    *,
    crew: Crew | None = None,
    progress: Progress | None = None,
    label: str = "designs",
) -> tuple[Evaluation, ...]:
    """Return the evaluations of designs in their order, read from their files or computed and kept.

    A SweepStateError is a failure that is not the design's own; the next run tries it again.

    Parameters
    ----------
    place, designs : Where they are evaluated, and the designs.
    folder : Folder of the evaluations.
    crew : Computes them; None: this process.
    progress : Shows designs, and files that cannot be used.
    label : What the bar is called.
    """
    kept = map_cases(
        evaluate,
        designs,
        context=place,
        folder=folder,
        codec=RecordCodec(Evaluation),
        leave_out=LEFT_OUT,
        crew=crew,
        progress=progress,
        label=label,
    )
    pairs = zip(kept, designs, strict=True)
    return tuple(replace(one.value, design=design) for one, design in pairs)


def slopes(place: Bench, case: SlopeCase) -> Slopes:
    """Return the derivatives of a design's scores: one solution, whatever the number of keys.

    Parameters
    ----------
    place, case : Where it is evaluated, and the design with the keys.
    """
    columns: dict[str, list[FloatArray]] = {name: [] for name in ARRAYS}
    sizes = []
    for name, tangent in tangents(case.design, place.study.radio, case.names).items():
        ends = [
            _scores_of(*_rss_of(place.setting, responses, place.distances_m))
            for responses in (tangent.before, tangent.after)
        ]
        over = 0.5 / tangent.step
        for score, column in columns.items():
            column.append(over * (ends[1][score] - ends[0][score]))
        sizes.append(over * _size_difference(place, case.design, name, tangent.step))
    footprint, height = np.array(sizes).reshape(-1, 2).T
    return Slopes(
        footprint_m=footprint,
        height_m=height,
        **{name: np.array(column) for name, column in columns.items()},
    )


def _size_difference(place: Bench, design: Reader, name: str, step: float) -> FloatArray:
    """Return by how much footprint and height [m] differ a step to either side of a key."""
    frequency = place.study.radio.frequency_hz
    value = key_value(design, name, frequency)
    ends = [
        np.array(with_values(design, {name: value + s}).size_m(frequency)) for s in (-step, step)
    ]
    difference: FloatArray = ends[1] - ends[0]
    return difference


def kept_slopes(
    place: Bench, case: SlopeCase, folder: Path, *, progress: Progress | None = None
) -> Slopes:
    """Return a design's derivatives, read from their file or computed and kept.

    Parameters
    ----------
    place, case : Where it is evaluated, and the design with the keys.
    folder : Folder of the evaluations.
    progress : Shows files that cannot be used.
    """
    (kept,) = map_cases(
        slopes,
        (case,),
        context=place,
        folder=folder,
        codec=RecordCodec(Slopes),
        leave_out=LEFT_OUT,
        progress=progress,
        label="derivatives",
    )
    found: Slopes = kept.value
    return found


def _beyond_limits(place: Bench, width_m: float, height_m: float) -> str:
    """Return why a design is larger than allowed; empty when it is not."""
    sizes = (
        ("footprint", width_m, place.footprint_m),
        ("height with plates and antennas", height_m, place.height_m),
    )
    for name, size_m, most_m in sizes:
        if size_m > most_m + LENGTHS.same_m:
            return f"its {name} is {1e3 * size_m:.1f} mm, but at most {1e3 * most_m:g} mm is free."
    return ""


def _scores(place: Bench, design: Reader) -> tuple[dict[str, FloatArray], tuple[str, ...]]:
    rss, azimuths, elements, notes = rss_over_azimuth(place.setting, design, place.distances_m)
    return _scores_of(rss, azimuths, elements), notes


def _scores_of(
    rss: FloatArray, azimuths: FloatArray, elements: FloatArray
) -> dict[str, FloatArray]:
    found = [score_rss(rss[i : i + 1], azimuths, elements) for i in range(len(rss))]
    return {
        "right_share": np.array([s.right_share for s in found]),
        "margin_db": np.array([s.margin_worst_db for s in found]),
        "bearing_error_deg": np.degrees([s.vector_rms_rad for s in found]),
        "front_to_back_db": np.array([s.front_to_back_mean_db for s in found]),
        "level_w": rss.max(axis=-1).mean(axis=-1),
    }
