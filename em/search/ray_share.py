"""What share of the power launched rays have found: an estimate, and a bound with 95 % confidence.

A ray stands for a part of the power that leaves an isotropic source. Summed over rays, the length
that they run after a sequence of planes, times what the walls leave of their power, is the power
that the sequence's paths bring, averaged over all receivers: a beam that spreads over r^2 brings a
receiver 1 / r^2 of it. Rays are launched in sets that know nothing of one another. The power of a
set's rays in sequences that no other set has met is, on average, what the other sets miss.
"""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from octant.em.medium.radio_scene import RadioScene
from octant.em.medium.reflection import wall_coefficients

FloatArray = npt.NDArray[np.float64]
IntArray = npt.NDArray[np.int64]

CONFIDENCE = 0.95
"""How often [-] no more than the bound is missing."""

UNMET = 3.0
"""Rays [-] whose share may be missing although none met it: exp(-3) is 1 - `CONFIDENCE`."""

INCIDENCES = 64
"""Cosines of incidence [-] at which walls are taken, from grazing to normal."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RayShare:
    """What share of the received power is missing of what launched rays have found.

    Power is summed over paths, and averaged over receivers throughout the scene's bounds; the
    source is isotropic, its wave not polarised, and diffraction does not count. Single receivers
    miss more, or nothing.

    Parameters
    ----------
    rays, sets : Rays launched, in so many independent sets.
    missing, at_most : Share [-] of the power that is missing: an estimate, a little too high; and
        what it does not exceed in 95 of 100 cases.
    tolerance_db : By how much [dB] the power was allowed to be too low; None: nothing was asked.
    """

    rays: int
    sets: int
    missing: float
    at_most: float
    tolerance_db: float | None = None

    @property
    def missing_db(self) -> float:
        """By how much the mean power is too low [dB]."""
        return _too_low_db(self.missing)

    @property
    def at_most_db(self) -> float:
        """By how much the mean power is too low at most [dB], in 95 of 100 cases."""
        return _too_low_db(self.at_most)

    @property
    def suffices(self) -> bool:
        """Whether the bound is within the tolerance."""
        return self.tolerance_db is None or self.at_most_db <= self.tolerance_db

    def attributes(self) -> dict[str, float]:
        """Return the numbers by name, as files of results keep them: rays, shares [-] and [dB]."""
        return {
            "rays": self.rays,
            "missing_share": self.missing,
            "missing_share_at_most": self.at_most,
            "missing_at_most_db": self.at_most_db,
        }

    def text(self) -> str:
        """Return a sentence that says what is missing, in shares and in [dB]."""
        asked = "" if self.tolerance_db is None else f" (allowed: {self.tolerance_db:g} dB)"
        return (
            f"{self.rays} rays found all but {100.0 * self.missing:.2g} % of the power, with 95 % "
            f"confidence all but {100.0 * self.at_most:.2g} %: levels are {self.at_most_db:.2g} dB "
            f"too low at most, on average over the room{asked}."
        )


def _too_low_db(share: float) -> float:
    return math.inf if share >= 1.0 else -10.0 * math.log10(1.0 - share)


def estimated_share(
    power: FloatArray,
    sets: IntArray,
    set_power: FloatArray,
    *,
    rays: int,
    tolerance_db: float | None,
) -> RayShare:
    """Return what share of the power is missing of all sequences that sets of rays have met.

    The mean over the sets of what each of them alone has met is unbiased for one set less (leave
    one out, as in the estimate of I. J. Good, Biometrika 40, 1953, p. 237, equation 9, but by power
    in place of number); its spread over the sets gives the bound, by Student's t.

    Parameters
    ----------
    power : (k,) float64 — Power of each sequence, of all sets together [-].
    sets : (k, 2) int64 — First and last set that met it.
    set_power : (s,) float64 — Power of all that each set met, the source's own included [-].
    rays : Rays of all sets.
    tolerance_db : What is allowed to be missing [dB].
    """
    count = len(set_power)
    alone = sets[:, 0] == sets[:, 1]
    single = np.bincount(sets[alone, 0], weights=power[alone], minlength=count)
    share = single / np.where(set_power > 0.0, set_power, 1.0)
    missing = float(share.mean())
    spread = float(share.std(ddof=1)) / math.sqrt(count)
    bound = missing + float(stdtrit(count - 1, CONFIDENCE)) * spread + UNMET / rays
    return RayShare(
        rays=rays,
        sets=count,
        missing=missing,
        at_most=min(1.0, bound),
        tolerance_db=tolerance_db,
    )


def wall_powers(radio: RadioScene) -> FloatArray:
    """Return what walls do to power that is not polarised, (materials, 2, 2, incidences) [-].

    By material, side (front, back), what is reflected and what is let through (0 where the scene
    lets nothing through), and the cosine of incidence in equal steps.

    Parameters
    ----------
    radio : Scene with its materials at one frequency.
    """
    incidence_rad = np.arccos((np.arange(INCIDENCES) + 0.5) / INCIDENCES)
    found = np.zeros((len(radio.materials), 2, 2, INCIDENCES))
    for row, material in zip(found, radio.materials, strict=True):
        for side, one in enumerate(row):
            wall = wall_coefficients(
                material, radio.frequency_hz, incidence_rad, from_front=side == 0
            )
            te, tm = np.abs(wall.reflection_te) ** 2, np.abs(wall.reflection_tm) ** 2
            one[0] = 0.5 * (te + tm)
            te, tm = np.abs(wall.transmission_te) ** 2, np.abs(wall.transmission_tm) ** 2
            one[1] = 0.5 * (te + tm)
    return found
