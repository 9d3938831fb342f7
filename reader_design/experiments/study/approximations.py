"""How far the two approximations are off the full-wave response of the chosen reader."""

import math

from octant.em.reader.comparison import FLOOR_DB, ResponseDifference, compare_responses
from octant.reader_design.setting.design import FULLWAVE, response_at
from octant.reader_design.setting.setting import Setting
from octant.reader_design.showing.pages import ReportTable

APPROXIMATIONS = ("rays", "isolated")
"""Models that are compared with the full-wave one [-]."""


def approximation_errors(setting: Setting) -> tuple[ResponseDifference, ...]:
    """Return both errors at the carrier ([dB], shares); none unless the study itself is full-wave.

    Parameters
    ----------
    setting : The reader; the sampled distances [m] say under which angles tags are seen.
    """
    import numpy as np

    study, design = setting.study, setting.reader
    if study.reader.response != FULLWAVE:
        return ()
    frequency_hz = study.radio.frequency_hz
    tag = setting.reference_tag
    rise_m = float(tag.position_m[2]) - setting.reader_z_m
    theta = np.arctan2(setting.sampling.distances_m(), rise_m)
    truth = response_at(design, frequency_hz)
    return tuple(
        compare_responses(truth, response_at(design, frequency_hz, model), theta.tolist())
        for model in APPROXIMATIONS
    )


def approximation_table(errors: tuple[ResponseDifference, ...]) -> ReportTable:
    """Return the errors of the approximations as a table ([dB], [%]).

    Parameters
    ----------
    errors : From `approximation_errors`, at least one.
    """
    rows = tuple(
        (
            e.model,
            f"{e.offset_db:+.1f}",
            f"{e.strong_rms_db:.1f}",
            f"{e.weak_rms_db:.1f}",
            f"{e.faint_rms_db:.1f}" if math.isfinite(e.faint_rms_db) else "none that faint",
            f"{100.0 * e.other_antenna_share:.0f}",
        )
        for e in errors
    )
    return ReportTable(
        caption="How far the approximations are off the full-wave response of this reader, above "
        "its ground plane: mean level where an antenna's gain is within 10 dB of its greatest, rms "
        f"differences after taking that out (gains below {FLOOR_DB:g} dB under the greatest count "
        "as that), and how often they name another antenna as the strongest for tags at the "
        "sweep's distances.",
        header=(
            "response",
            "mean level [dB]",
            "rms within 10 dB [dB]",
            "rms 10–20 dB below [dB]",
            "rms further down [dB]",
            "another strongest antenna [% of azimuths]",
        ),
        rows=rows,
    )
