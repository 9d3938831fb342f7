"""Which experiment reads which tables of a study: what it would ignore is refused, not ignored."""

from collections.abc import Mapping
from pathlib import Path

import msgspec

from octant.geometries.errors import ConfigError
from octant.reader_design.study_file.loading import resolved
from octant.reader_design.study_file.schema import Study

_PARTS_OF_A_STUDY = frozenset(
    ("sweep", "scoring", "choice", "map", "mission", "robot", "sensor", "tolerance", "layout")
)
"""`octant study` reads all of these, and the verbs that do one part of it read the same file."""

READ_BY: Mapping[str, frozenset[str]] = {
    "study": _PARTS_OF_A_STUDY,
    "sweep": _PARTS_OF_A_STUDY,
    "navigate": _PARTS_OF_A_STUDY,
    "tolerance": _PARTS_OF_A_STUDY,
    "optimise": frozenset(("optimise", "scoring")),
    "track": frozenset(("track", "robot")),
    "dock": frozenset(("dock", "robot", "sensor", "layout")),
}
"""Tables that a verb heeds, by its name, besides what all heed: the room, tags, reader and solver.

Verbs that answer one question about a study (paths, explain, scene, map, rss, reader) take any
study, whatever experiments it describes.
"""

_FOR_SOME = frozenset.union(*READ_BY.values())


def check_tables(study: Study, verb: str) -> None:
    """Refuse a study with a table that says something to other experiments only.

    A table in which every key has its default says nothing, so that `study.toml`, where every
    default is written out, can be run again.

    Parameters
    ----------
    study : A loaded study.
    verb : A key of `READ_BY`.
    """
    silent = resolved(Study(room=study.room, reader=study.reader), directory=Path("/"))
    for field in msgspec.structs.fields(Study):
        table = field.encode_name
        if table not in _FOR_SOME - READ_BY[verb]:
            continue
        if getattr(study, field.name) != getattr(silent, field.name):
            readers = [f"'octant {other}'" for other, read in READ_BY.items() if table in read]
            msg = (
                f"the study has a table [{table}], which 'octant {verb}' does not read; "
                f"{' and '.join(readers)} {'does' if len(readers) == 1 else 'do'}: remove the "
                f"table, or keep it in a study of its own."
            )
            raise ConfigError(msg)
