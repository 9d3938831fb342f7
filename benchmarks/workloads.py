"""The workloads that Octant and its peers run, and how they are timed.

Scenes and exact path counts are those of ``tests/reference/peers/README.md``: 2.4 GHz, a vertical
half-wave dipole at (3.5, 2, 2.9) m, specular reflections only, from half-spaces or slabs of 0.1 m.
"""

import time
import tracemalloc
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from octant.em.antennas.kinds import make_antenna
from octant.em.fields.gains import path_gains
from octant.em.medium.materials import material
from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.power.radio_map import map_antenna
from octant.em.search.candidates import Candidates
from octant.em.search.images import search_images
from octant.geometries.mesh_files import load_bodies
from octant.geometries.scene import build_scene

MESHES = Path(__file__).resolve().parents[1] / "tests" / "reference" / "peers"
FREQUENCY_HZ = 2.4e9
SOURCE_M = (3.5, 2.0, 2.9)
RECEIVER_Z_M = 0.3
WALL_THICKNESS_M = {"halfspace": None, "slab0.1": 0.1}
ROOM = (("room.ply", "concrete"),)
CABINET = (*ROOM, ("w3_cabinet.ply", "metal"))
DENSE = (*CABINET, ("w5_metal.ply", "metal"), ("w5_wood.ply", "wood"))


@dataclass(frozen=True, slots=True, kw_only=True)
class Workload:
    """One scene, one grid of receivers and the most reflections of a path.

    Parameters
    ----------
    name : str
        As in the table of the peers.
    meshes : tuple of (str, str)
        Mesh files and their materials; the first is the room.
    order : int
        Most reflections.
    side : int
        The grid is side x side receivers.
    exact_paths : int or None
        Exact number of paths, where it is known in closed form or by exhaustive search.
    samples : int
        Rays that Sionna RT launches at its best setting: fewer lose paths, more only take longer.
    peers : tuple of str
        Who can run it.
    """

    name: str
    meshes: tuple[tuple[str, str], ...]
    order: int
    side: int
    exact_paths: int | None = None
    samples: int = 0
    peers: tuple[str, ...] = ()

    @property
    def is_map(self):
        """Whether peers estimate mean power on a grid of cells, and no paths."""
        return self.name == "W4"

    @property
    def axes_m(self):
        """Both axes of the grid [m]: the peers' places, or the centres of the cells of a map."""
        i = np.arange(self.side)
        if self.is_map:
            return (i + 0.5) * (5.0 / self.side), (i + 0.5) * (5.0 / self.side)
        return 0.0531 + i * 4.8938 / (self.side - 1), 0.0517 + i * 4.8966 / (self.side - 1)

    @property
    def receivers_m(self):
        """Every receiver, (side * side, 3) [m], in the order of a map."""
        x, y = np.meshgrid(*self.axes_m, indexing="ij")
        return np.column_stack((x.ravel(), y.ravel(), np.full(x.size, RECEIVER_Z_M)))


ALL = ("sionna", "differt", "pyroom")
WORKLOADS = {
    w.name: w
    for w in (
        Workload(
            name="W1", meshes=ROOM, order=3, side=50, exact_paths=157_500, samples=1000, peers=ALL
        ),
        Workload(
            name="W1-200",
            meshes=ROOM,
            order=3,
            side=200,
            exact_paths=2_520_000,
            samples=1000,
            peers=("sionna",),
        ),
        Workload(
            name="W2", meshes=ROOM, order=5, side=50, exact_paths=577_500, samples=30_000, peers=ALL
        ),
        Workload(name="W2-200", meshes=ROOM, order=5, side=200, exact_paths=9_240_000),
        Workload(
            name="W3",
            meshes=CABINET,
            order=3,
            side=50,
            exact_paths=139_667,
            samples=10_000,
            peers=ALL,
        ),
        Workload(name="W3-200", meshes=CABINET, order=3, side=200),
        Workload(name="W4", meshes=ROOM, order=5, side=100, samples=1_400_000, peers=("sionna",)),
        Workload(name="W5", meshes=DENSE, order=2, side=20, samples=1_000_000, peers=("sionna",)),
    )
}


def wall_materials(workload, walls):
    """Return the materials of a workload by name; ``walls`` is one of `WALL_THICKNESS_M`."""
    names = {name for _, name in workload.meshes}
    thickness_m = WALL_THICKNESS_M[walls]
    return {name: material({"name": name, "thickness_m": thickness_m}) for name in names}


def workload_scene(workload, walls="halfspace"):
    """Return a workload's scene, and the same at 2.4 GHz."""
    room, *objects = (
        load_bodies(MESHES / file, unit="m", material=name) for file, name in workload.meshes
    )
    scene = build_scene(room, objects=[body for bodies in objects for body in bodies])
    return scene, radio_scene(scene, FREQUENCY_HZ, wall_materials(workload, walls))


def octant_map(workload, scene, radio):
    """Return the map of one receiving antenna: image search, exact paths, fields, both powers."""
    x, y = workload.axes_m
    return map_antenna(
        radio,
        Candidates(images=search_images(scene, SOURCE_M, workload.order)),
        x_m=x,
        y_m=y,
        z_m=RECEIVER_Z_M,
        transmitter=make_antenna("dipole", FREQUENCY_HZ),
        receiver=make_antenna("isotropic_theta", FREQUENCY_HZ),
        power_w=1.0,
    )


def octant_paths(workload, scene, radio):
    """Return receiver, length [m] and complex gain of every path."""
    tree = search_images(scene, SOURCE_M, workload.order)
    paths = trace_paths(radio, Candidates(images=tree), workload.receivers_m)
    gains = path_gains(
        radio,
        paths,
        transmitter=make_antenna("dipole", FREQUENCY_HZ),
        receiver=make_antenna("isotropic_theta", FREQUENCY_HZ),
    )
    return {"receiver": paths.receiver, "length_m": paths.length_m, "gain": gains.gain}


def timed(work):
    """Return the seconds of one run and those of all cores, (2,), and its result."""
    start, cpu = time.perf_counter(), time.process_time()
    result = work()
    return np.array([time.perf_counter() - start, time.process_time() - cpu]), result


def best_of(repetitions, work):
    """Return the least seconds of a few runs, as `timed`, and the result of the last."""
    runs = [timed(work) for _ in range(repetitions)]
    return np.min([seconds for seconds, _ in runs], axis=0), runs[-1][1]


def peak_mib(work):
    """Return the greatest memory that Python and NumPy held during one run [MiB]."""
    tracemalloc.start()
    work()
    peak = tracemalloc.get_traced_memory()[1] / 2**20
    tracemalloc.stop()
    return peak
