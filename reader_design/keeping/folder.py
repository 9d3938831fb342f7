"""The folder of a sweep's cells: where files lie, and that nothing half-written stays there."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # no Unix
    fcntl = None  # type: ignore[assignment]


def cell_path(folder: Path, key: str) -> Path:
    """Return where a cell's file lies.

    Parameters
    ----------
    folder : Path
        Folder of the sweep's cells.
    key : str
        Name of the cell.

    Returns
    -------
    Path
        A netCDF file named by the first 32 digits of the key.
    """
    return folder / f"{key[:32]}.nc"


@contextmanager
def sweep_folder(folder: Path) -> Iterator[None]:
    """Yield while a sweep may write to a folder; clear what killed runs left half-written.

    Parameters
    ----------
    folder : Path
        Folder of the sweep's cells.

    Notes
    -----
    Every run holds a shared lock on the folder, which the system takes back when the process ends,
    however it ends. A run that gets the lock for itself is the only one, so that temporary files
    can be nobody's. Where folders cannot be locked (other systems, some network disks) they stay.
    """
    with suppress(OSError):  # said by the first file that cannot be written
        folder.mkdir(parents=True, exist_ok=True)
    if fcntl is None or not folder.is_dir():
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            for left in folder.glob(".*.nc"):
                left.unlink(missing_ok=True)
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_SH)
        yield
    finally:
        os.close(handle)
