"""Octant's exceptions and its two warning classes, shared by every layer.

A message says what was given, what is allowed and what to do, in one sentence; the command line
prints it as it is and exits with code 2.
"""


class OctantError(Exception):
    """Base of everything that Octant raises on purpose."""


class GeometryError(OctantError, ValueError):
    """A mesh, a room, an object or a place in it cannot be used as given."""


class MaterialRangeError(OctantError, ValueError):
    """A material is unknown, or a frequency lies outside the range of its model."""


class AntennaError(OctantError, ValueError):
    """An antenna or a reader response cannot be built or evaluated with the given values."""


class PatternFileError(OctantError, ValueError):
    """An antenna pattern file cannot be read; the message names the file and the line."""


class NavigationError(OctantError, ValueError):
    """A robot, a controller or a mission cannot be built with the given values."""


class ConfigError(OctantError, ValueError):
    """A study file or a command-line value is wrong; the message names the key."""


class ResultError(OctantError, ArithmeticError):
    """What was computed cannot be true, so that it is not written; the message names the place."""


class InfeasibleDesignError(ConfigError):
    """A reader whose numbers are sound one by one, but that nobody can build together."""


class SweepStateError(OctantError, RuntimeError):
    """The files of a sweep contradict each other or the study they are said to belong to."""


class PhysicsWarning(UserWarning):
    """A model is used outside the range in which it is known to hold."""


class CacheWarning(UserWarning):
    """Something that was computed cannot be kept for the next run; results do not change."""
