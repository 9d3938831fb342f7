"""Solving the reader of a setting while a person sees that it is being solved."""

from octant.reader_design.keeping.progress import Progress
from octant.reader_design.setting.cost import reader_cost
from octant.reader_design.setting.setting import Setting

SOLVING = "solving the reader"


def solved(setting: Setting, progress: Progress) -> Setting:
    """Return the setting with its responses; a PhysicsWarning says what does not hold.

    Parameters
    ----------
    setting, progress : The reader in its room; shows about how long it still takes.
    """
    expected_s = reader_cost(setting.study, setting.reader).seconds
    with progress.during(SOLVING, expected_s=expected_s):
        return setting.solved()
