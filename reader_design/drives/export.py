"""``--export`` of the verbs that drive: the files of some runs, written once."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from octant.geometries.errors import ConfigError
from octant.reader_design.drives.files import (
    DRIVES,
    DriveFile,
    check_kinds,
    drive_names,
    left_out,
    write_drive,
)
from octant.reader_design.drives.log import DriveLog
from octant.reader_design.keeping.progress import Progress
from octant.reader_design.keeping.results import write_once

OUTPUTS = f"{DRIVES}/*"
"""Pattern of the files in a folder of results."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveExport:
    """Which runs are written, and as what.

    Parameters
    ----------
    kinds, runs : Of `files.DRIVE_FILES`; numbers of the runs, none: run 0.
    """

    kinds: tuple[DriveFile, ...] = ()
    runs: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        """Return whether anything is written."""
        return bool(self.kinds)

    @property
    def numbers(self) -> tuple[int, ...]:
        """The runs that are written, each once."""
        return tuple(dict.fromkeys(self.runs or (0,)))

    def check(self, runs: int) -> None:
        """Refuse what cannot be written, before anything is computed.

        Parameters
        ----------
        runs : How many there are.
        """
        if self.runs and not self.kinds:
            msg = "--export-run says which run to write, but not as what; add --export mcap."
            raise ConfigError(msg)
        beyond = [number for number in self.numbers if number >= runs]
        if self.kinds and beyond:
            msg = f"--export-run is {beyond[0]}, but the runs are numbered 0 to {runs - 1}."
            raise ConfigError(msg)
        check_kinds(self.kinds)


def write_drives(
    logs: Mapping[str, Callable[[], DriveLog]],
    export: DriveExport,
    folder: Path,
    *,
    stamp: Path,
    inputs: Sequence[object],
    force: bool,
    progress: Progress,
) -> tuple[Path, ...]:
    """Return the folder with the files of drives, once written; empty: none is asked for.

    Parameters
    ----------
    logs : What makes each drive's log, by its name.
    export, folder : What is written; the folder of the results.
    stamp, inputs, force, progress : As for `write_once`; ``inputs`` decide the drives.
    """
    if not export:
        return ()
    names = dict(zip(logs, drive_names(list(logs)), strict=True))

    def write() -> list[Path]:
        written: list[Path] = []
        with progress.track(logs.items(), total=len(logs), label="drives") as each:
            for name, make in each:
                log = make()
                if note := left_out(log, export.kinds):
                    progress.say(note)
                written += write_drive(log, folder / DRIVES / names[name], export.kinds)
        return written

    write_once(
        stamp,
        [list(export.kinds), list(export.numbers), list(logs), *inputs],
        write,
        force=force,
        progress=Progress(),
    )
    return (folder / DRIVES,)
