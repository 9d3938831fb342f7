"""How well poses explain a reading of all tags: by field maps, or by places that tags may have."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from octant.em.power.field_maps import FieldMap
from octant.navigation.navigators._pose_kernels import offset_log_likelihood, pose_log_likelihood
from octant.navigation.navigators.drawing import systematic
from octant.navigation.navigators.tag_places import TagPlaces

FloatArray = npt.NDArray[np.float64]

PLACES = 8
"""Places of a tag by which poses are weighed [-]."""

POSES = 24
"""Poses at which places of a tag are weighed [-]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A reading of all tags, and what its likelihood needs beside the field.

    Parameters
    ----------
    rss_db : (t, n) float64 — Readings over 1 W [dB]; -inf where nothing was received.
    level_db, level_variance, gain_db : (t,), (t,), (n,) float64 — What is known of the tags' levels
        and the antennas' gains, [dB] and [dB²].
    trusted : (t, s + 1) float64 — Probabilities of the shares before it, and of an outlier [-].
    floors_w, fading_db, noise_db, outlier_db, trust : As `PoseFilter` has them.
    """

    rss_db: FloatArray
    level_db: FloatArray
    level_variance: FloatArray
    gain_db: FloatArray
    trusted: FloatArray
    floors_w: FloatArray
    fading_db: FloatArray
    noise_db: float
    outlier_db: float
    trust: float

    def by_map(
        self, maps: FieldMap, poses: FloatArray, *, share: tuple[float, float]
    ) -> tuple[FloatArray, FloatArray]:
        """Return log-likelihoods (m,) of poses by field maps, and the shares' probabilities after.

        Parameters
        ----------
        maps, poses : Of all tags; (3, m) x, y [m], heading [rad].
        share : Power of the error field over the local mean that is expected, and that may well be
            there [-].
        """
        logs = np.empty(poses.shape[1])
        parts = np.empty((poses.shape[1], *self.trusted.shape))
        pose_log_likelihood(
            np.ascontiguousarray(poses), _grid(maps.x_m, maps.y_m), maps.levels,
            _grid(maps.node_x_m, maps.node_y_m), maps.means, maps.powers_w, maps.ring,
            maps.shift_rad * maps.levels.shape[4] / (2.0 * math.pi), self.rss_db, self.level_db,
            self.level_variance, self.gain_db, supposed_shares(*share), self.floors_w,
            self.noise_db, self.fading_db, self.outlier_db, self.trust, self.trusted, logs, parts,
        )  # fmt: skip
        return logs, parts

    def by_places(
        self,
        maps: FieldMap,
        places: TagPlaces,
        poses: FloatArray,
        rng: np.random.Generator,
        *,
        drawn: Sequence[int | None],
        shares: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Return log-likelihoods (m, t) of poses, of each tag's reading, and the shares' after.

        Some places of each tag are drawn, and all poses are weighed by the mean over these; or by
        its mean place.

        Parameters
        ----------
        maps, places : For the local means; where the tags may hang.
        poses, rng : (3, m) x, y [m], heading [rad]; draws the places.
        drawn : For each tag, how many of its places; None: the mean of all.
        shares : (t,) float64 — Power of each tag's expected error field over the local mean [-].
        """
        logs = np.zeros((poses.shape[1], len(self.rss_db)))
        parts = np.empty((poses.shape[1], *self.trusted.shape))
        means_m = places.mean_m()
        for tag, count in enumerate(drawn):
            some = means_m[tag : tag + 1] if count is None else places.drawn(tag, count, rng)
            _, logs[:, tag], parts[:, tag] = self._one(
                maps, places, tag, poses, some, share=float(shares[tag])
            )
        return logs, parts

    def of_places(
        self,
        maps: FieldMap,
        places: TagPlaces,
        poses: FloatArray,
        rng: np.random.Generator,
        *,
        weights: FloatArray,
        shares: FloatArray,
        wanted: npt.NDArray[np.bool_],
    ) -> list[FloatArray | None]:
        """Return for each tag the log-likelihood of its reading at every place that it may have.

        Parameters
        ----------
        maps, places, poses, rng, shares : As for `by_places` [m], [rad], [-].
        weights : (m, t) float64 — Probabilities of the poses by all that is known but the reading
            of that tag [-].
        wanted : (t,) bool — Tags that are looked for; of others None is returned.
        """
        found: list[FloatArray | None] = []
        for tag in range(len(self.rss_db)):
            if not wanted[tag] or not np.any(self.rss_db[tag] > -np.inf):
                found.append(None)
                continue
            some = poses[:, systematic(weights[:, tag], POSES, rng)]
            each, _, _ = self._one(
                maps, places, tag, some, places.offsets_m[tag], share=float(shares[tag])
            )
            most = each.max()
            found.append(most + np.log(np.mean(np.exp(each - most), axis=0) + 1e-300))
        return found

    def _one(
        self,
        maps: FieldMap,
        places: TagPlaces,
        tag: int,
        poses: FloatArray,
        offsets: FloatArray,
        *,
        share: float,
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        pose = np.ascontiguousarray(poses.T)
        powers = places.survey.paths[tag].shifted_w(pose, offsets)
        means = np.maximum(maps.local_mean_w(pose, tag=tag), maps.powers_w[tag, 1])
        each = np.empty(powers.shape[:2])
        logs, parts = np.empty(len(pose)), np.empty((len(pose), self.trusted.shape[1]))
        offset_log_likelihood(
            powers, means, self.rss_db[tag], self.level_db[tag], self.level_variance[tag],
            self.gain_db, supposed_shares(share), self.floors_w[tag], self.noise_db,
            self.fading_db[tag], self.outlier_db, self.trust, self.trusted[tag], each, logs, parts,
        )  # fmt: skip
        return each, logs, parts


def supposed_shares(least: float, more: float = 0.0) -> FloatArray:
    """Return the supposed shares of the error field: expected, more, everything, (3,) [-].

    More is half way to everything, in decibels, or what may well be there, if that is greater.

    Parameters
    ----------
    least, more : What is expected, and what may well be there [-].
    """
    least = min(max(least, 1e-3), 0.9)
    return np.array([least, max(math.sqrt(least), min(more, 0.95)), 1.0])


def _grid(x_m: FloatArray, y_m: FloatArray) -> FloatArray:
    return np.array([x_m[0], y_m[0], x_m[1] - x_m[0], y_m[1] - y_m[0]])
