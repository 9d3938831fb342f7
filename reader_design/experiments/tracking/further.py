"""The chapters that are computed where a study names them, by their names."""

from octant.reader_design.experiments.tracking import (
    frames,
    horizons,
    laboratory,
    law_on_line,
    long_drives,
    reader_part,
    slam_line,
    stabilisation,
    tag_numbers,
)
from octant.reader_design.experiments.tracking.parts import FurtherChapter

FURTHER: dict[str, FurtherChapter] = {
    "tags": tag_numbers.CHAPTER,
    "frames": frames.CHAPTER,
    "law": law_on_line.CHAPTER,
    "long": long_drives.CHAPTER,
    "stabilisation": stabilisation.CHAPTER,
    "horizon": horizons.CHAPTER,
    "slam line": slam_line.CHAPTER,
    "laboratory": laboratory.CHAPTER,
    "reader": reader_part.CHAPTER,
}
"""In the order of the report."""
