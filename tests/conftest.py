"""Settings of every test: reproducible property tests without deadlines."""

from hypothesis import settings

settings.register_profile("octant", derandomize=True, deadline=None)
settings.load_profile("octant")
