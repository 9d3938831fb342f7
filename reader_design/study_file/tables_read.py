"""Which experiment reads which tables of a study: what it would ignore is refused, not ignored."""

from collections.abc import Mapping
from pathlib import Path

import msgspec

from octant.geometries.errors import ConfigError
from octant.reader_design.study_file.loading import resolved
from octant.reader_design.study_file.schema import Study

READ_BY: Mapping[str, tuple[str, ...]] = {
    "sweep": ("study", "sweep"),
    "scoring": ("study", "sweep", "optimise", "tolerance"),
    "choice": ("study",),
    "map": ("study", "map", "track"),
    "mission": ("study", "navigate"),
    "robot": ("study", "navigate", "track", "dock"),
    "sensor": ("study", "navigate", "dock", "track", "rss"),
    "track": ("track",),
    "dock": ("dock",),
    "optimise": ("optimise",),
    "tolerance": ("study", "tolerance"),
    "layout": ("study", "dock"),
    "report": ("study",),
    "rfid": ("study", "sweep", "navigate", "optimise", "tolerance", "dock", "map", "rss"),
    "truth": ("study", "navigate"),
}
"""The verbs that read a table, by its name; the other tables are read by all.

``[log]`` stays with a study that was fitted to it, and says nothing else of the room.
"""

SHARE_A_STUDY = frozenset(("study", "sweep", "navigate", "tolerance", "optimise"))
"""Each does a part of designing a reader, and leaves in its study to the others what is theirs."""

EXPERIMENTS = SHARE_A_STUDY | {"track", "dock"}
"""The verbs that compute what a study describes.

Those that answer one question about it (paths, explain, scene, map, rss, reader), and those for
logs (simulate-log, replay, compare, calibrate), take any study.
"""


def belongs(table: str, verb: str) -> bool:
    """Return whether a table may say something in the study that a verb is given.

    Parameters
    ----------
    table, verb : Names as in a study file and on the command line.
    """
    readers = READ_BY.get(table, (verb,))
    shared = verb in SHARE_A_STUDY and SHARE_A_STUDY.intersection(readers)
    return verb in readers or verb not in EXPERIMENTS or bool(shared)


def check_tables(study: Study, verb: str) -> None:
    """Refuse a study with a table that says something to other experiments only.

    A table in which every key has its default says nothing, so that `study.toml`, where every
    default is written out, can be run again.

    Parameters
    ----------
    study : A loaded study.
    verb : One of `EXPERIMENTS`.
    """
    silent = resolved(Study(room=study.room, reader=study.reader), directory=Path("/"))
    for field in msgspec.structs.fields(Study):
        if belongs(field.encode_name, verb):
            continue
        if getattr(study, field.name) != getattr(silent, field.name):
            readers = READ_BY[field.encode_name]
            names = " and ".join(f"'octant {reader}'" for reader in readers)
            msg = (
                f"the study has a table [{field.encode_name}], which 'octant {verb}' does not "
                f"read; {names} {'does' if len(readers) == 1 else 'do'}: remove the table, or "
                "keep it in a study of its own."
            )
            raise ConfigError(msg)
