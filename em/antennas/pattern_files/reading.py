"""Pattern files of any known format, recognised by suffix or content."""

import re
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Literal, get_args

from octant.em.antennas.pattern_files._lines import read_lines, refusal
from octant.em.antennas.pattern_files.common import PatternTable
from octant.em.antennas.pattern_files.cst_text import read_cst_text
from octant.em.antennas.pattern_files.cuts import read_csv
from octant.em.antennas.pattern_files.ffd import read_ffd
from octant.em.antennas.pattern_files.ffe import read_ffe
from octant.em.antennas.pattern_files.ffs import read_ffs
from octant.em.antennas.pattern_files.msi import read_msi
from octant.em.antennas.pattern_files.nec import read_nec
from octant.em.antennas.pattern_files.ngmn import read_ngmn
from octant.geometries.errors import PatternFileError, PhysicsWarning

PatternFormat = Literal["ffe", "ffd", "ffs", "cst", "nec", "msi", "ngmn", "csv"]
"""FEKO, HFSS, CST (source and text), NEC listings, MSI/Planet, NGMN BASTA, Octant's own CSV."""

_BY_SUFFIX: dict[str, PatternFormat] = {
    ".ffe": "ffe",
    ".ffd": "ffd",
    ".ffs": "ffs",
    ".nout": "nec",
    ".msi": "msi",
    ".pln": "msi",
    ".json": "ngmn",
    ".csv": "csv",
}
_BY_CONTENT: tuple[tuple[str, PatternFormat], ...] = (
    (r"(?im)^//\s*CST Farfield Source", "ffs"),
    (r"(?im)^\W*Theta\s*\[deg", "cst"),
    (r"\A\s*[\[{]", "ngmn"),
    (r"(?im)^#+\s*(File Type:\s*Far\s*Field|Frequency:)", "ffe"),
    (r"-\s*RADIATION PATTERNS\s*-", "nec"),
    (r"(?im)^\s*HORIZONTAL\s+\d+", "msi"),
    (r"(?im)^[^#\n]*\b(theta_deg|angle_deg)\b", "csv"),
    (r"\A\s*\S+[ \t]+\S+[ \t]+\d+\s*\n\s*\S+[ \t]+\S+[ \t]+\d+\s*\n", "ffd"),
)
_READERS: dict[PatternFormat, Callable[[Path], tuple[PatternTable, ...]]] = {
    "ffs": read_ffs,
    "cst": read_cst_text,
    "nec": read_nec,
    "msi": read_msi,
    "ngmn": read_ngmn,
    "csv": read_csv,
}


def read_pattern(
    path: str | Path,
    *,
    format: str | None = None,  # noqa: A002  # the natural word; nothing here formats
    incident_power_w: float | None = None,
) -> tuple[PatternTable, ...]:
    """Return the patterns of a file in its order, one table an antenna and frequency.

    An unknown format or malformed file is refused with file and line. Doubts about the content,
    above all a format without phase, are warned of.

    Parameters
    ----------
    path : The file.
    format : One of `PatternFormat`; None: by suffix or content.
    incident_power_w : Power [W] incident on the port where the file does not tell: ``.ffd`` (1 W
        unless given) and ``.ffe`` without gain columns.
    """
    path = Path(path)
    if incident_power_w is not None and not 0.0 < incident_power_w < float("inf"):
        msg = f"{path}: incident_power_w = {incident_power_w} W; give a power above 0 W."
        raise PatternFileError(msg)
    found = _format(path, format)
    if found == "ffe":
        tables = read_ffe(path, incident_power_w=incident_power_w)
    elif found == "ffd":
        tables = read_ffd(path, incident_power_w=incident_power_w or 1.0)
    else:
        tables = _READERS[found](path)
    for text in dict.fromkeys(text for table in tables for text in table.warnings):
        warnings.warn(text, PhysicsWarning, stacklevel=2)
    return tables


def _format(path: Path, name: str | None) -> PatternFormat:
    """Return the format that is named, or that suffix or content show."""
    for known in get_args(PatternFormat):
        if name == known:
            return known  # type: ignore[no-any-return]  # get_args loses the Literal
    if name is not None:
        allowed = ", ".join(get_args(PatternFormat))
        msg = f"pattern format {name!r} is unknown; allowed are {allowed}."
        raise PatternFileError(msg)
    if path.suffix.lower() in _BY_SUFFIX:
        return _BY_SUFFIX[path.suffix.lower()]
    text = "\n".join(read_lines(path))
    for pattern, found in _BY_CONTENT:
        if re.search(pattern, text):
            return found
    what = f"no known pattern format; name one of {', '.join(get_args(PatternFormat))}."
    raise refusal(path, 1, what)
