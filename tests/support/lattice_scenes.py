"""Scenes whose coordinates lie on a lattice, their paths, and those of places close by.

Planes are shared, edges are aligned, ends stand symmetrically: all that random places never meet.
What is right at such a place is what its neighbours, 1e-6 m away, have on either side or between.
``OCTANT_LATTICE_SCENES=10000 pytest tests/em/paths/test_lattice_places.py`` tries as many seeds.
"""

from collections import Counter, defaultdict
from dataclasses import dataclass
from itertools import chain

import numpy as np

from octant.em.antennas.kinds import make_antenna
from octant.em.fields.gains import path_gains
from octant.em.medium.materials import material
from octant.em.paths.tracing import trace_paths
from octant.em.records import DIFFRACTION, NOTHING, TRANSMITTED
from octant.em.search.candidates import SolverSettings, radio_scenes, search_candidates
from octant.geometries.bodies import Body
from octant.geometries.furniture import box
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

F = 2.4e9
AXIS = np.array([0.3, -0.2, 1.0])
MATERIALS = {
    "pane": material({"name": "glass", "thickness_m": 0.01}),
    "panel": material({"name": "plasterboard", "thickness_m": 0.0125}),
}
JITTER_M = 1e-6
SAME_M = 1e-4  # vertices of one path here and at a neighbour
STEP = 1e-2  # share of a path's field above which it steps between neighbours: a boundary passes
DB = 1e-6 * np.log(10.0) / 20.0  # 1e-6 dB of a field


@dataclass(frozen=True, slots=True, kw_only=True)
class LatticeScene:
    """Bodies, both ends and the solver's settings."""

    room: tuple[Body, ...]
    objects: tuple[Body, ...]
    ends: np.ndarray
    solver: SolverSettings

    def moved(self, turn, shift):
        """Return the same scene turned and shifted."""

        def move(body):
            return Body(
                name=body.name,
                vertices_m=body.vertices_m @ turn.T + shift,
                faces=body.faces,
                material=body.material,
            )

        return LatticeScene(
            room=tuple(map(move, self.room)),
            objects=tuple(map(move, self.objects)),
            ends=self.ends @ turn.T + shift,
            solver=self.solver,
        )


def sheet(rng, size, name):
    """A plate on the lattice, parallel to two axes; every third from wall to wall."""
    axis = int(rng.integers(3))
    low, high = np.zeros(3), np.array(size)
    if rng.random() > 0.34:
        for a in range(3):
            low[a], high[a] = np.sort(rng.choice(np.arange(int(2 * size[a]) + 1), 2, False)) / 2.0
    low[axis] = high[axis] = rng.integers(1, int(2 * size[axis])) / 2.0
    u, v = (a for a in range(3) if a != axis)
    corners = np.tile(low, (4, 1))
    corners[1:3, u], corners[2:, v] = high[u], high[v]
    kind = ("metal", "wood", "pane", "panel")[int(rng.integers(4))]
    return Body(name=name, vertices_m=corners, faces=[[0, 1, 2], [0, 2, 3]], material=kind)


def cabinet(rng, size, name):
    low, high = np.empty(3), np.empty(3)
    for a in range(3):
        low[a], high[a] = np.sort(rng.choice(np.arange(int(2 * size[a]) + 1), 2, False)) / 2.0
    high = np.minimum(high, low + 2.0)
    if rng.random() < 0.5:
        high[2] -= low[2]
        low[2] = 0.0
    kind = ("metal", "wood", "pane")[int(rng.integers(3))]
    return box(high - low, position_m=low, material=kind, name=name)


def lattice_scene(seed):
    """Return the scene of a seed: a room or none, up to three bodies, both ends on the lattice."""
    rng = np.random.default_rng(seed)
    size = rng.integers(2, 6, 3) * 1.0
    room = tuple(box_room(tuple(size))) if rng.random() < 0.8 else ()
    count = int(rng.integers(1, 4))
    objects = tuple(
        (cabinet if rng.random() < 0.6 else sheet)(rng, size, f"body{i}") for i in range(count)
    )
    solver = SolverSettings(
        max_reflections=int(rng.integers(1, 4 if count < 3 else 3)),
        diffraction=bool(rng.random() < 0.7),
        max_diffractions=int(rng.integers(1, 3)),
        transmission=bool(rng.random() < 0.4),
    )
    scene = build_scene(room, objects=objects)
    step = 4.0 if rng.random() < 0.5 else 2.0
    for _ in range(100):
        ends = rng.integers(1, (step * size).astype(int), (2, 3)) / step
        if rng.random() < 0.5:  # level, or above one another, or mirror images of one another
            a = int(rng.integers(3))
            ends[1, a] = ends[0, a]
        off = (scene.distance_to_facets_m(ends, within_m=1e-3)[1] < 0).all()
        apart = np.linalg.norm(ends[0] - ends[1]) > 0.2
        if off and apart and not scene.inside_solid(ends).any():
            return LatticeScene(room=room, objects=objects, ends=ends, solver=solver)
    return lattice_scene(seed + 1_000_000_000)  # no room is left between the bodies


def neighbours(place, count):
    """Return places about a place, the first one itself."""
    rng = np.random.default_rng(17)
    away = rng.normal(size=(count, 3))
    away *= JITTER_M / np.linalg.norm(away, axis=1)[:, None]
    return np.vstack((place, place + away))


class Solved:
    """The paths of a scene from one source to several receivers, and their gains."""

    def __init__(self, case, source, receivers, axis=AXIS):
        scene = build_scene(case.room, objects=case.objects)
        self.radio = radio_scenes(scene, [F], case.solver, MATERIALS)[0]
        antenna = make_antenna("dipole", F, axis=axis)
        found = search_candidates(self.radio, source, case.solver)
        self.paths = trace_paths(self.radio, found, receivers)
        self.gain = path_gains(self.radio, self.paths, transmitter=antenna, receiver=antenna).gain
        self.count = len(receivers)

    def total(self, receiver=0):
        return self.gain[self.paths.receiver == receiver].sum()

    def scale(self, receiver=0):
        return np.sqrt((np.abs(self.gain[self.paths.receiver == receiver]) ** 2).sum())

    def words(self):
        """Yield receiver, what a path meets in turn, where it is bent, and its gain.

        Where it passes through a sheet is left out: along a sheet that is nowhere in particular.
        """
        f, wedges = self.radio.scene.facets, self.radio.wedges
        for k in range(len(self.paths)):
            met = []
            bent = [True]
            for kind, element in zip(self.paths.kind[k], self.paths.element[k], strict=True):
                if kind == DIFFRACTION:
                    met.append((kind, *sorted(f.facet_plane[wedges.facets[element]].tolist())))
                elif kind != NOTHING:
                    met.append((kind, int(f.facet_plane[element])))
                if kind != NOTHING:
                    bent.append(kind != TRANSMITTED)
            vertices = self.paths.vertices_of(k)[[*bent, True]]
            yield int(self.paths.receiver[k]), tuple(met), vertices, self.gain[k]

    def bundles(self):
        """Return {what is met: [(vertices, Counter of receivers, readings, gains), ...]}.

        Vertices within SAME_M, in whichever order they are read, are one path.
        """
        by_word = defaultdict(list)
        for receiver, word, vertices, gain in self.words():
            for seen, counts, readings, gains in by_word[tuple(sorted(word))]:
                if np.abs(seen - vertices).max() < SAME_M:
                    counts[receiver] += 1
                    readings.add(word)
                    gains[receiver] += gain
                    break
            else:
                gains = np.zeros(self.count, dtype=complex)
                gains[receiver] = gain
                bundle = (vertices, Counter({receiver: 1}), {word}, gains)
                by_word[tuple(sorted(word))].append(bundle)
        return by_word


def same_nearby(vertices, counts, readings, gains):
    """Return whether neighbours have a path too, in the same order, with the same field."""
    # Which wall of a corner reflects first depends on the end's side of a plane.
    apart = np.abs(np.diff(vertices, axis=0)).max(axis=1).min() > SAME_M
    steps = np.abs(gains - gains[0]).max() > STEP * np.abs(gains).max()
    equal = all(counts[i] == counts[0] for i in range(len(gains)))
    return apart and equal and not steps and len(readings) == 1


def faults_of_case(case, *, jitters=12):
    """Return what is wrong with a scene's paths and fields, as sentences; none is right."""
    found = []
    a, b = case.ends
    here = Solved(case, a, neighbours(b, jitters))
    own = here.paths.receiver == 0
    if not np.isfinite(here.paths.vertices_m).all() or not np.isfinite(here.gain).all():
        return ["not finite"]
    back = Solved(case, b, neighbours(a, jitters))
    if not np.isfinite(back.gain).all():
        return ["not finite on the way back"]
    returning = (back.paths.receiver == 0).sum()
    if own.sum() != returning:
        found.append(f"{own.sum()} paths there, {returning} back")
    if abs(here.total() - back.total()) > 1e-9 * here.scale():
        found.append(f"not reciprocal: {here.total()} there, {back.total()} back")
    if abs(here.total()) > 1.0:
        found.append(f"gain of {abs(here.total())}")
    bundles = here.bundles()
    clusters = chain(*bundles.values(), *back.bundles().values())
    sharp = all(same_nearby(*cluster) for cluster in clusters)
    odd = []
    for word, clusters in bundles.items():
        for vertices, counts, _, _ in clusters:
            near = [counts[i] for i in range(1, jitters + 1)]
            if not min(near) <= counts[0] <= max(near):
                odd.append((word, vertices, counts[0], min(near), max(near)))
    for sources, receivers in ((jitters, jitters), (60, 80)):  # the source's neighbours too
        if odd:
            odd = list(_nowhere_near(case, odd, sources, receivers))
    found += [
        f"{count} paths {word} by {np.round(vertices, 6).tolist()}, at neighbours {least} to {most}"
        for word, vertices, count, least, most in odd
    ]
    if sharp:
        turn, shift = generic_move()
        moved = case.moved(turn, shift)
        there = Solved(moved, moved.ends[0], [moved.ends[1]], axis=turn @ AXIS)
        off = abs(there.total() - here.total()) > DB * max(abs(here.total()), 0.01 * here.scale())
        if not np.isfinite(there.gain).all():
            found.append("not finite when moved")
        elif (off or len(there.paths) != own.sum()) and _is_sharp(case, here):
            found.append(
                f"{own.sum()} paths and {here.total()}, {len(there.paths)} and {there.total()} "
                "when moved"
            )
    return found


def _is_sharp(case, here, count=12):
    """Return whether all has the same paths and field where both ends are moved a little."""
    a, b = case.ends
    for place in neighbours(a, count)[1:]:
        near = Solved(case, place, neighbours(b, count))
        for i in range(1, count + 1):
            same = (near.paths.receiver == i).sum() == (here.paths.receiver == 0).sum()
            if not same or abs(near.total(i) - here.total()) > STEP**2 * here.scale():
                return False
    return True


def _nowhere_near(case, odd, sources, receivers):
    """Yield those of some bundles of which no neighbours have as many; some are had by few."""
    a, b = case.ends
    more = [
        Solved(case, place, neighbours(b, receivers)).bundles()
        for place in neighbours(a, sources)[1:]
    ]
    for word, vertices, count, least, most in odd:
        seen = [least, most]
        for bundles in more:
            near = Counter()
            for seen_at, counts, _, _ in bundles[word]:
                if np.abs(seen_at - vertices).max() < SAME_M:
                    near = counts
            seen += [near[i] for i in range(1, receivers + 1)]
        if not min(seen) <= count <= max(seen):
            yield word, vertices, count, min(seen), max(seen)


def generic_move():
    turn, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn)), np.array([0.137, -0.291, 0.413])
