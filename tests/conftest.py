"""Settings of every test: how many examples a property is tried on, one cache for all workers.

``OCTANT_EXAMPLES=full`` tries each property on as many examples as Hypothesis does by default,
anything else (profile ``quick``) on a few.
"""

import gc
import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

COMMON = {
    "derandomize": True,
    "deadline": None,
    # Fixtures of these tests hand out folders and readers, which examples do not change.
    "suppress_health_check": [HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
}
settings.register_profile("quick", max_examples=10, **COMMON)
settings.register_profile("full", max_examples=200, **COMMON)
settings.load_profile("full" if os.environ.get("OCTANT_EXAMPLES") == "full" else "quick")


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """Keep what Octant caches out of the user's folder; workers of one session share it.

    Processes that tests start read the package that is tested, whose kernels are compiled, not one
    that stands in the current folder.
    """
    folder = Path(tmp_path_factory.getbasetemp())
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("OCTANT_CACHE_DIR", str(folder / "octant-cache"))
        patch.setenv("PYTHONSAFEPATH", "1")
        yield


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Let no garbage collection look through what collection has made, which stays to the end."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()
