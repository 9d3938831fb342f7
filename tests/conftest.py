"""Settings of every test: reproducible property tests without deadlines, a cache of its own."""

import pytest
from hypothesis import settings

settings.register_profile("octant", derandomize=True, deadline=None)
settings.load_profile("octant")


@pytest.fixture(scope="session", autouse=True)
def own_cache(tmp_path_factory):
    """Keep what Octant caches out of the user's folder, and away from earlier runs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("OCTANT_CACHE_DIR", str(tmp_path_factory.mktemp("octant-cache")))
        yield
