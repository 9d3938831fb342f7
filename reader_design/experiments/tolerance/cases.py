"""One case: a design, built and used with given deviations, and its scores."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec
import numpy as np
import numpy.typing as npt

from octant.em.antennas.embedded import ReaderResponse
from octant.em.decibels import power_dbm
from octant.em.medium.materials import Material
from octant.em.medium.radio_scene import RadioScene, radio_scene
from octant.em.reader.cache import cached_responses
from octant.reader_design.experiments.tolerance.draws import Deviation
from octant.reader_design.keeping.keeper import RecordCodec, map_cases
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.design import reader_responses
from octant.reader_design.setting.evaluation import room_samples_w
from octant.reader_design.setting.samples import free_points_m, grid_azimuths_rad, sample_rss_w
from octant.reader_design.setting.scores import score_rss
from octant.reader_design.setting.setting import Setting, build_setting
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.schema import Radio, Study
from octant.reader_design.study_file.scores import Scores

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
"""What cannot change a case, so that its key does not contain it: of ``[tolerance]`` the case holds
its own errors, and the context what is scored; of the mission only the first tag matters."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ToleranceContext:
    """What all cases share; picklable.

    Attributes
    ----------
    setting : Study, its room and how densely designs are probed [m].
    distances_m : Horizontal distances in free space [m].
    room : Whether to score in the room, too.
    reference : Id of the tag that the scores in free space use.
    """

    setting: Setting
    distances_m: tuple[float, ...]
    room: bool
    reference: str

    @property
    def study(self) -> Study:
        """The study."""
        return self.setting.study


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Case:
    """What is to be computed.

    Attributes
    ----------
    design, deviation : The drawing, and what is built less what is drawn.
    """

    design: Reader
    deviation: Deviation


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseScores:
    """What came out.

    Attributes
    ----------
    reason : Why there are no scores; empty when there are.
    free, room : Scores in free space at the given distances, and in the room.
    levels_dbm : The strongest antenna's RSS at each distance, mean over azimuth, free space [dBm].
    """

    reason: str = ""
    free: Scores | None = None
    room: Scores | None = None
    levels_dbm: tuple[float, ...] = ()


def compute_case(context: ToleranceContext, case: Case) -> CaseScores:
    """Return the scores of one case, or refuse it with an OctantError if it cannot be built.

    Scores take the antennas to be where the drawing has them, as a navigator does.

    Parameters
    ----------
    context, case : What all cases share; the case.
    """
    context = _shifted(context, case.deviation)
    return scores_of(context, built_responses(context.study, case))


def scores_of(context: ToleranceContext, responses: tuple[ReaderResponse, ...]) -> CaseScores:
    """Return the scores of a reader by its responses.

    Parameters
    ----------
    context, responses : What all cases share; patterns at each frequency.
    """
    setting = context.setting.with_responses(responses)
    sampling = setting.sampling
    elements = np.asarray(responses[0].azimuths_rad, dtype=np.float64)
    azimuths = grid_azimuths_rad(elements.size, sampling.free_azimuths)
    tag = setting.reference_tag
    link, origin = setting.free_link(tag), tag.position_m[:2]
    rss = sample_rss_w(link, origin + free_points_m(context.distances_m), origin, azimuths)
    usable = setting.usable_dbm
    room = None
    if context.room:
        room_azimuths = grid_azimuths_rad(elements.size, sampling.room_azimuths)
        in_room = room_samples_w(setting, room_azimuths)
        room = score_rss(in_room, room_azimuths, elements, usable_dbm=usable)
    return CaseScores(
        free=score_rss(rss, azimuths, elements, usable_dbm=usable),
        room=room,
        levels_dbm=tuple(power_dbm(rss.max(axis=-1).mean(axis=-1)).tolist()),
    )


def run_cases(
    context: ToleranceContext,
    cases: Sequence[Case],
    folder: Path,
    *,
    workers: int | None = 1,
    cluster: str | None = None,
    progress: Progress | None = None,
) -> tuple[CaseScores, ...]:
    """Return the scores of cases in their order, read from their files or computed and kept.

    Parameters
    ----------
    context, cases : What all cases share; designs and deviations.
    folder : Where the cases' files lie; made when missing.
    workers, cluster, progress : As in :func:`octant.reader_design.keeping.keeper.map_cases`.
    """
    kept = map_cases(
        compute_case,
        cases,
        context=context,
        folder=folder,
        codec=RecordCodec(CaseScores),
        leave_out=LEFT_OUT,
        workers=workers,
        cluster=cluster,
        progress=progress,
        label="readers",
        name=lambda _: "one of the readers",
    )
    return tuple(CaseScores(reason=one.reason) if one.reason else one.value for one in kept)


def built_responses(study: Study, case: Case) -> tuple[ReaderResponse, ...]:
    """Return the patterns of a design as built at each frequency; only the drawing's are cached.

    Parameters
    ----------
    study, case : Frequencies and the model of the reader; design and errors.
    """
    errors = case.deviation.build
    if errors.is_zero and case.deviation.frequency_factor == 1.0:
        return reader_responses(case.design, study.radio)
    cut = msgspec.structs.replace(case.design, antenna_length_m=_drawn_length_m(study, case))
    solutions = cached_responses(
        cut.body(errors),
        cut.element(study.radio.frequencies_hz[0]),
        study.radio.frequencies_hz,
        cells_per_wavelength=cut.cells_per_wavelength,
        keep=False,
        feeding=cut.feeding(),
        **cut.feed(),
    )
    return tuple(solution.response for solution in solutions)


def _drawn_length_m(study: Study, case: Case) -> float:
    """Return the antennas' length [m], resonant at the frequency that the drawing is for."""
    drawn_hz = study.radio.frequency_hz / case.deviation.frequency_factor
    return float(case.design.element(drawn_hz).length_m)


def _shifted(context: ToleranceContext, deviation: Deviation) -> ToleranceContext:
    """Return the context with another frequency and other materials, where they deviate."""
    study, setting = context.study, context.setting
    usable_dbm = setting.usable_dbm
    factor = deviation.frequency_factor
    if factor != 1.0:
        radio = study.radio
        shifted = Radio(
            frequency_hz=factor * radio.frequency_hz,
            channels_hz=tuple(factor * f for f in radio.channels_hz),
            tag_power_w=radio.tag_power_w,
        )
        study = msgspec.structs.replace(study, radio=shifted)
        setting = build_setting(study, sampling=setting.sampling)
    factors = (deviation.permittivity_factor, deviation.conductivity_factor)
    if factors != (1.0, 1.0):
        setting = _other_materials(setting, *factors)
    return replace(context, setting=replace(setting, usable_dbm=usable_dbm))


def _other_materials(setting: Setting, permittivity: float, conductivity: float) -> Setting:
    """Return the room with its materials' constants multiplied by two factors."""

    def other(radio: RadioScene) -> RadioScene:
        names = setting.scene.material_names
        changed = [scaled_material(m, permittivity, conductivity) for m in radio.materials]
        return radio_scene(
            radio.scene,
            radio.frequency_hz,
            dict(zip(names, changed, strict=True)),
            transmission=setting.study.solver.transmission,
            wedges=radio.wedges,
        )

    return replace(setting, radios=tuple(other(radio) for radio in setting.radios))


def scaled_material(material: Material, permittivity: float, conductivity: float) -> Material:
    """Return a material times two factors, in each layer alike; perfect conductors stay.

    Parameters
    ----------
    material : The study's own.
    permittivity : Factor of the relative permittivity less one [-], so that air stays air.
    conductivity : Factor of the conductivity [-].
    """
    if material.is_pec:
        return material
    return replace(
        material,
        eps_r_a=1.0 + permittivity * (material.eps_r_a - 1.0),
        sigma_c_s_per_m=conductivity * material.sigma_c_s_per_m,
        layers=tuple(scaled_material(m, permittivity, conductivity) for m in material.layers),
    )
