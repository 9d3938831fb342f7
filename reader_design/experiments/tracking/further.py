"""The chapters that are computed where a study names them, by their names."""

from octant.reader_design.experiments.tracking import tag_numbers
from octant.reader_design.experiments.tracking.parts import FurtherChapter

FURTHER: dict[str, FurtherChapter] = {
    "tags": tag_numbers.CHAPTER,
}
"""In the order of the report."""
