"""The versions that decide numbers."""

import platform
from functools import cache
from importlib import metadata


def versions() -> dict[str, str]:
    """Return the versions that decide numbers, for the attributes of a result.

    ``not installed`` stands for Octant run from a working tree.
    """
    packages = ("octant", "numpy", "scipy", "numba", "trimesh")
    found = {f"{package}_version": _version(package) for package in packages}
    return {"python_version": platform.python_version(), **found}


@cache  # thousands of cells ask, and each answer means reading files
def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "not installed"
