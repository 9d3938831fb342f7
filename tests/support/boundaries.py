"""Where the set of paths changes along a curve, and the field on both sides of it."""

from typing import NamedTuple

import numpy as np

from octant.em.antennas.kinds import make_antenna
from octant.em.fields.gains import path_gains
from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.records import DIFFRACTION
from octant.em.search.candidates import SolverSettings, search_candidates
from octant.geometries.wedges import Wedges, find_wedges

F = 2.4e9
WAVELENGTH = 299_792_458.0 / F
SENDER = make_antenna("dipole", F, axis=(1.0, 0.6, -0.8))
TAKERS = tuple(make_antenna("dipole", F, axis=a) for a in ((0, 0, 1), (1, 0.2, 0), (0.1, 1, 0)))


class Link(NamedTuple):
    """A scene with its candidates from one source."""

    radio: object
    candidates: object
    source: np.ndarray


def link(
    scene,
    source,
    order,
    *,
    diffractions=1,
    transmission=False,
    materials=None,
    region=None,
    edges=None,
):
    """Return the link from a source; only the wedges of ``edges`` diffract, if it is given."""
    wedges = find_wedges(scene)
    if edges is not None:
        wedges = only(wedges, edges)
    radio = radio_scene(scene, F, materials, transmission=transmission, wedges=wedges)
    found = search_candidates(
        radio,
        source,
        SolverSettings(max_reflections=order, diffraction=True, max_diffractions=diffractions),
        region_m=region,
    )
    return Link(radio, found, np.asarray(source, float))


def only(wedges, rows):
    """Return some of the wedges."""
    return Wedges(**{name: getattr(wedges, name)[rows] for name in Wedges.__slots__})


def trace(link, places):
    return trace_paths(link.radio, link.candidates, places)


def signatures(link, places, letters="RT"):
    """Return per place the set of paths whose interactions are all of these letters."""
    paths = trace(link, places)
    found = [set() for _ in places]
    for k, row in enumerate(paths.receiver):
        word = "".join(paths.letters_of(k))
        if set(word) <= set(letters) and (not letters.startswith("D") or "D" in word):
            found[row].add((word, *paths.element[k, : len(word)]))
    return found


def totals(link, places, *, diffracted=True):
    """Return (m, 3) sums of complex gains over the paths, for three receiving antennas."""
    paths = trace(link, places)
    chosen = diffracted | ~(paths.kind == DIFFRACTION).any(axis=1)
    sums = np.zeros((len(places), len(TAKERS)), complex)
    for i, taker in enumerate(TAKERS):
        gain = path_gains(link.radio, paths, transmitter=SENDER, receiver=taker).gain
        np.add.at(sums[:, i], paths.receiver[chosen], gain[chosen])
    return sums


def incident(link, places):
    """Return the greatest gain that the free path between two dipoles can have, (m,)."""
    distance = np.linalg.norm(np.asarray(places) - link.source, axis=1)
    return 1.641 * WAVELENGTH / (4.0 * np.pi * distance)


def find_boundaries(link, curve, samples, letters="RT"):
    """Return parameters just below and above each change of the signature along curve(t)."""
    t = np.asarray(samples, float)
    seen = signatures(link, curve(t), letters)
    at = [i for i in range(len(t) - 1) if seen[i] != seen[i + 1]]
    low, high = t[at].copy(), t[[i + 1 for i in at]].copy()
    left = [seen[i] for i in at]
    while len(low):
        step = np.linalg.norm(curve(high) - curve(low), axis=1)
        if step.max() < 1e-9:
            break
        middle = 0.5 * (low + high)
        same = np.array(
            [a == b for a, b in zip(signatures(link, curve(middle), letters), left, strict=True)]
        )
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    apart = high - low  # a step further, beyond the tolerances about the edge itself
    return low - 2.0 * apart, high + 2.0 * apart


def jumps(link, curve, low, high, *, diffracted=True):
    """Return the change of the total field across boundaries, over the incident field."""
    change = totals(link, curve(high), diffracted=diffracted)
    change -= totals(link, curve(low), diffracted=diffracted)
    return np.abs(change).max(axis=1) / incident(link, curve(low))


def optical_jumps(link, curve, low, high):
    """Return the change of what does not diffract, over the incident field."""
    return jumps(link, curve, low, high, diffracted=False)
