"""The table ``[calibration]`` of a study: what measurements add to the levels that are computed."""

from typing import TYPE_CHECKING, Annotated

from msgspec import Meta

from octant.reader_design.study_file.quantities import Name, Ratio
from octant.reader_design.study_file.room import Table

if TYPE_CHECKING:
    from octant.reader_design.study_file.schema import Study


class Calibration(Table, frozen=True, kw_only=True):
    """Levels that measurements have found: table ``[calibration]``, of `octant calibrate`.

    Parameters
    ----------
    level_db : By tag, how far its received level lies above the computed one [dB]: its true power,
        cables, scale of the receiver. Maps, readings and missions count it to the tag's power.
    diffuse_db : By tag, path gain of the diffuse field [dB] that furniture and all that the mesh
        lacks scatter evenly through the building; it adds to the power sum over paths, before
        ``level_db``. `octant compare` and `octant calibrate` use it.
    antenna_db : By antenna of the reader, how far its level lies above the computed one [dB], for
        the same two.
    """

    level_db: dict[Name, Ratio] = {}  # noqa: RUF012  msgspec copies it
    diffuse_db: dict[Name, Ratio] = {}  # noqa: RUF012
    antenna_db: Annotated[tuple[Ratio, ...], Meta(max_length=100)] = ()


def sent_w(study: "Study", tag_id: str) -> float:
    """Return the power that a tag counts as sending [W]: the study's, and its calibrated level.

    Parameters
    ----------
    study, tag_id : The study; one of its tags.
    """
    level_db = 0.0 if study.calibration is None else study.calibration.level_db.get(tag_id, 0.0)
    return float(study.radio.tag_power_w * 10.0 ** (0.1 * level_db))
