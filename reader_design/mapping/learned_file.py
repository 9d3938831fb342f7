"""What missions have learnt, as a TOML file that the next mission reads."""

from pathlib import Path
from typing import Annotated

import msgspec
import numpy as np
from msgspec import Meta

from octant.geometries.errors import ConfigError, NavigationError
from octant.navigation.navigators.learned import Learned
from octant.reader_design.study_file.errors import sentence
from octant.reader_design.study_file.toml import toml_text
from octant.reader_design.study_file.toml_files import toml_file_text, toml_tables

Vector = tuple[float, float, float]
Deviation = Annotated[float, Meta(ge=0.0, le=1000.0)]


class LearnedTag(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What was found of a tag.

    Parameters
    ----------
    id : Its id.
    offset_m, offset_sd_m : Where it hangs from its surveyed place; the deviations of that [m].
    level_db, level_sd_db : By how much it reads more than its map; the deviation of that [dB].
    """

    id: str
    offset_m: Vector
    offset_sd_m: tuple[Deviation, Deviation, Deviation]
    level_db: float
    level_sd_db: Deviation


class LearnedFile(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The file.

    Parameters
    ----------
    missions : How many missions it comes from.
    gain_db, gain_sd_db : By how much each antenna reads more than the others; the deviations [dB].
    tag : The tags.
    """

    missions: Annotated[int, Meta(ge=1, le=1_000_000)]
    gain_db: tuple[float, ...]
    gain_sd_db: tuple[Deviation, ...]
    tag: tuple[LearnedTag, ...]


def learned_text(learned: Learned) -> str:
    """Return the text of the file.

    Parameters
    ----------
    learned : From a mission [m], [dB].
    """
    tags = zip(
        learned.tags, learned.offset_m.tolist(), learned.offset_sd_m.tolist(),
        learned.level_db.tolist(), learned.level_sd_db.tolist(), strict=True,
    )  # fmt: skip
    keys = ("id", "offset_m", "offset_sd_m", "level_db", "level_sd_db")
    return toml_text(
        {
            "missions": learned.missions,
            "gain_db": learned.gain_db.tolist(),
            "gain_sd_db": learned.gain_sd_db.tolist(),
            "tag": [dict(zip(keys, tag, strict=True)) for tag in tags],
        }
    )


def read_learned(path: Path) -> Learned:
    """Return what a file holds [m], [dB].

    Parameters
    ----------
    path : The file.
    """
    what = "file of what missions have learnt"
    tables = toml_tables(toml_file_text(path, what=what), source=str(path))
    try:
        found = msgspec.convert(tables, LearnedFile)
    except msgspec.ValidationError as exc:
        msg = f"{path}: {sentence(exc, tables, LearnedFile)}"
        raise ConfigError(msg) from exc
    try:
        return Learned(
            tags=tuple(tag.id for tag in found.tag),
            offset_m=np.array([tag.offset_m for tag in found.tag]).reshape(-1, 3),
            offset_sd_m=np.array([tag.offset_sd_m for tag in found.tag]).reshape(-1, 3),
            level_db=np.array([tag.level_db for tag in found.tag]),
            level_sd_db=np.array([tag.level_sd_db for tag in found.tag]),
            gain_db=np.array(found.gain_db),
            gain_sd_db=np.array(found.gain_sd_db),
            missions=found.missions,
        )
    except NavigationError as exc:
        msg = f"{path}: {exc}"
        raise ConfigError(msg) from exc
