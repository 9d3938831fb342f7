"""What a robot has learnt of a room's tags and of its reader, to be used by its next missions."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Learned:
    """What missions in a room have found out, and how well.

    Parameters
    ----------
    tags : Ids of the tags, in the order of the arrays.
    offset_m, offset_sd_m : (t, 3) float64 — Where each tag hangs from its surveyed place, and the
        deviations of that [m]; those of the survey where nothing was searched for.
    level_db, level_sd_db : (t,) float64 — By how much it reads more than its map, and the deviation
        [dB].
    gain_db, gain_sd_db : (n,) float64 — The same of each antenna [dB].
    missions : How many missions that comes from.
    """

    tags: tuple[str, ...]
    offset_m: FloatArray
    offset_sd_m: FloatArray
    level_db: FloatArray
    level_sd_db: FloatArray
    gain_db: FloatArray
    gain_sd_db: FloatArray
    missions: int = 1

    def __post_init__(self) -> None:
        t, n = len(self.tags), len(self.gain_db)
        for name, shape in (
            ("offset_m", (t, 3)),
            ("offset_sd_m", (t, 3)),
            ("level_db", (t,)),
            ("level_sd_db", (t,)),
            ("gain_db", (n,)),
            ("gain_sd_db", (n,)),
        ):
            array = frozen_array(getattr(self, name), name=name, shape=shape, error=NavigationError)
            if name.endswith(("sd_m", "sd_db")) and not bool((array >= 0.0).all()):
                msg = f"{name} is {array.min():g}, but a deviation is 0 or more."
                raise NavigationError(msg)
            object.__setattr__(self, name, array)

    def of(self, tags: tuple[str, ...], *, antennas: int) -> "Learned":
        """Return the same in another order of the tags; a tag or a reader that it lacks is refused.

        Parameters
        ----------
        tags, antennas : Ids of the tags; number of antennas of the reader.
        """
        missing = sorted(set(tags) - set(self.tags))
        if missing or antennas != len(self.gain_db):
            what = f"tags {missing}" if missing else f"a reader of {antennas} antennas"
            msg = (
                f"what was learnt is of tags {list(self.tags)} and {len(self.gain_db)} antennas, "
                f"but the study has {what}: learn anew."
            )
            raise NavigationError(msg)
        at = [self.tags.index(tag) for tag in tags]
        return Learned(
            tags=tags,
            offset_m=self.offset_m[at],
            offset_sd_m=self.offset_sd_m[at],
            level_db=self.level_db[at],
            level_sd_db=self.level_sd_db[at],
            gain_db=self.gain_db,
            gain_sd_db=self.gain_sd_db,
            missions=self.missions,
        )
