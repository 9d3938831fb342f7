"""Where tags really hang: particles of each tag's offset from its survey, found while driving.

A tag that hangs half a wavelength beside its place fades elsewhere: the map of its surveyed place
is then worth no more than the local mean. But its fades follow from three numbers, and readings of
eight antennas over a metre of the way say which. Given the robot's pose the tags are independent of
one another, and given the tags' places so are readings of the pose: each is weighed by the other's
particles (assumed-density filtering; what a pose and an offset have in common is not kept).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from octant.em.power.path_maps import PathMap
from octant.geometries._arrays import frozen_array
from octant.geometries.errors import NavigationError
from octant.navigation.checks import check_positive
from octant.navigation.navigators.drawing import systematic

FloatArray = npt.NDArray[np.float64]

_CELL_M = 0.02
_PER_CELL, _PER_CELL_AT_START = 40, 80
_FRESH_SHARE = 0.02
_DISBELIEVED = 0.1
_BLUR = 0.5
_LEAST_BLUR_M = 0.001


@dataclass(frozen=True, slots=True, kw_only=True)
class TagSurvey:
    """How tags were surveyed, and how they are heard when they hang elsewhere.

    Parameters
    ----------
    paths : Of every tag, in the order of the readings.
    sd_m : (t, 3) float64 — Deviation of the survey along x, y, z [m].
    known_m, known_sd_m : (t, 3) float64 — Offsets that earlier drives have found, and the
        deviations of these [m]; without any 0 and those of the survey.
    most, least : Number of places of a tag that are weighed: at first, and when it is known.
    """

    paths: tuple[PathMap, ...]
    sd_m: FloatArray
    known_m: FloatArray
    known_sd_m: FloatArray
    most: int = 1500
    least: int = 150

    def __post_init__(self) -> None:
        for name in ("sd_m", "known_m", "known_sd_m"):
            array = frozen_array(
                getattr(self, name), name=name, shape=(len(self.paths), 3), error=NavigationError
            )
            object.__setattr__(self, name, array)
        for name in ("most", "least"):
            check_positive(getattr(self, name), name=name, unit="places")

    def start(self, rng: np.random.Generator) -> "TagPlaces":
        """Return what is believed before the first reading.

        Parameters
        ----------
        rng : Source of the places.
        """
        found = [self._at_start(tag, rng) for tag in range(len(self.paths))]
        weights = tuple(np.full(len(one), 1.0 / len(one)) for one in found)
        return TagPlaces(survey=self, offsets_m=tuple(found), weights=weights)

    def _at_start(self, tag: int, rng: np.random.Generator) -> FloatArray:
        """Return places of a tag as earlier drives have found it, and some as the survey has it."""
        cells = (2.0 * math.pi) ** 1.5 * float(np.prod(self.known_sd_m[tag] / _CELL_M))
        count = max(min(round(_PER_CELL_AT_START * cells), self.most), self.least)
        surveyed = round(_DISBELIEVED * count)
        draws = rng.standard_normal((count - surveyed, 3))
        known = self.known_m[tag] + self.known_sd_m[tag] * draws
        return np.concatenate([known, self.prior(tag, surveyed, rng)])

    def prior(self, tag: int, count: int, rng: np.random.Generator) -> FloatArray:
        """Return places of a tag as the survey has them, (count, 3) [m].

        Parameters
        ----------
        tag, count, rng : Which tag; how many; their source.
        """
        drawn: FloatArray = self.sd_m[tag] * rng.standard_normal((count, 3))
        return drawn


@dataclass(frozen=True, slots=True, kw_only=True)
class TagPlaces:
    """What is believed of the tags' offsets from their survey.

    Parameters
    ----------
    survey : How they were surveyed.
    offsets_m : For each tag (k, 3) float64 — Where it may hang, from its surveyed place [m].
    weights : For each tag (k,) float64 — Probabilities of these, adding up to one [-].
    """

    survey: TagSurvey
    offsets_m: tuple[FloatArray, ...]
    weights: tuple[FloatArray, ...]

    def mean_m(self) -> FloatArray:
        """Return the mean offset of each tag, (t, 3) [m]."""
        return np.array([w @ o for w, o in zip(self.weights, self.offsets_m, strict=True)])

    def sd_m(self) -> FloatArray:
        """Return the deviation along an axis, root mean square of the three, of each tag, (t,)."""
        return np.array(
            [
                math.sqrt(float(w @ np.sum((o - w @ o) ** 2, axis=1)) / 3.0)
                for w, o in zip(self.weights, self.offsets_m, strict=True)
            ]
        )

    def drawn(self, tag: int, count: int, rng: np.random.Generator) -> FloatArray:
        """Return places of a tag that are equally likely, (count, 3) [m].

        Parameters
        ----------
        tag, count, rng : Which tag; how many; source of the one random number it takes.
        """
        return self.offsets_m[tag][systematic(self.weights[tag], count, rng)]

    def gap_m(self, tag: int, count: int) -> float:
        """Return about how far so many drawn places of a tag are apart [m].

        Parameters
        ----------
        tag, count : Which tag; how many places.
        """
        offsets, weights = self.offsets_m[tag], self.weights[tag]
        off = offsets - weights @ offsets
        spread = np.linalg.eigvalsh((weights[:, None] * off).T @ off)
        round_one = (2.0 * math.pi) ** 1.5 * math.sqrt(float(np.prod(np.maximum(spread, 1e-8))))
        volume = min(round_one, _cells(offsets, weights) * _CELL_M**3)
        return float((volume / count) ** (1.0 / 3.0))

    def weighed(self, logs: Sequence[FloatArray | None], rng: np.random.Generator) -> "TagPlaces":
        """Return the places weighed by a reading, drawn anew where under half of them count.

        Parameters
        ----------
        logs : For each tag (k,) float64 — Log-likelihood of its reading for each place [-];
            None: it was not heard.
        rng : Source of new places.
        """
        places = self
        for tag, found in enumerate(logs):
            if found is None:
                continue
            weights = places.weights[tag] * np.exp(found - found.max())
            places = _with(places, tag, places.offsets_m[tag], weights / weights.sum())
            if 1.0 / float(np.sum(places.weights[tag] ** 2)) < 0.5 * len(weights):
                places = places.drawn_anew(tag, rng)
        return places

    def drawn_anew(self, tag: int, rng: np.random.Generator) -> "TagPlaces":
        """Return the places of a tag drawn anew, blurred by their gaps, with some as surveyed.

        Parameters
        ----------
        tag, rng : Which tag; source of the places.
        """
        offsets, weights, survey = self.offsets_m[tag], self.weights[tag], self.survey
        wanted = round(_PER_CELL * _cells(offsets, weights))
        count = max(min(wanted, survey.most), survey.least, round(0.5 * len(weights)))
        fresh = max(1, round(_FRESH_SHARE * count))
        blur = max(_BLUR * self.gap_m(tag, count), _LEAST_BLUR_M)
        kept = offsets[systematic(weights, count - fresh, rng)]
        kept = kept + blur * rng.standard_normal(kept.shape)
        offsets = np.concatenate([kept, survey.prior(tag, fresh, rng)])
        return _with(self, tag, offsets, np.full(count, 1.0 / count))


def _with(places: TagPlaces, tag: int, offsets: FloatArray, weights: FloatArray) -> TagPlaces:
    def at(values: tuple[FloatArray, ...], value: FloatArray) -> tuple[FloatArray, ...]:
        return (*values[:tag], value, *values[tag + 1 :])

    return replace(
        places,
        offsets_m=at(places.offsets_m, offsets),
        weights=at(places.weights, weights),
    )


def _cells(offsets: FloatArray, weights: FloatArray) -> float:
    """Return in how many cells of 2 cm the places are, by their entropy [-]."""
    number = np.floor(offsets / _CELL_M).astype(np.int64) @ np.array([1, 1000, 1_000_000])
    _, at = np.unique(number, return_inverse=True)
    shares = np.bincount(at.ravel(), weights=weights)
    shares = shares[shares > 0.0]
    return math.exp(-float(np.sum(shares * np.log(shares))))
