"""Path counts and powers against the closed-form box and Sionna RT."""

import csv
from pathlib import Path

import numpy as np
import pytest

from octant.em.antennas import make_antenna
from octant.em.image_search import search_images
from octant.em.materials import material
from octant.em.paths import path_gains, trace_paths
from octant.em.radio_scene import radio_scene
from octant.geometries.mesh_files import load_bodies
from octant.geometries.scene import build_scene

HERE = Path(__file__).parent
F = 2.4e9
TX = (3.5, 2.0, 2.9)
ORDER = {"W1": 3, "W2": 5, "W3": 3}
"""Workloads that are run here, and their order."""
THEIR_DIPOLE_GAIN, OUR_DIPOLE_GAIN = 1.643, 1.640922376984585


def rows():
    with (HERE / "reference_powers.csv").open() as file:
        return [r for r in csv.DictReader(file) if r["workload"] in ORDER]


@pytest.fixture(scope="module")
def scenes():
    room = load_bodies(HERE / "room.ply", unit="m", material="concrete")
    cabinet = load_bodies(HERE / "w3_cabinet.ply", unit="m", material="metal")
    empty, furnished = build_scene(room), build_scene(room, objects=cabinet)
    return {
        "W1": (empty, search_images(empty, TX, 3)),
        "W2": (empty, search_images(empty, TX, 5)),
        "W3": (furnished, search_images(furnished, TX, 3)),
    }


def grid(n):
    i = np.arange(n)
    x, y = 0.0531 + i * 4.8938 / (n - 1), 0.0517 + i * 4.8966 / (n - 1)
    return np.array([(a, b, 0.3) for a in x for b in y])


@pytest.mark.parametrize(
    ("workload", "by_order"),
    [
        ("W1", [2500, 15000, 45000, 95000]),
        ("W2", [2500, 15000, 45000, 95000, 165000, 255000]),
        ("W3", [2372, 13563, 39801, 83931]),
    ],
)
def test_path_counts_are_exact(scenes, workload, by_order):
    scene, tree = scenes[workload]
    paths = trace_paths(radio_scene(scene, F), tree, grid(50))
    assert np.bincount(paths.order).tolist() == by_order


@pytest.mark.parametrize(
    "row", rows(), ids=lambda r: f"{r['workload']}-{r['walls']}-{r['peer']}-{r['point']}"
)
def test_powers_equal_the_reference(scenes, row):
    scene, tree = scenes[row["workload"]]
    materials = None
    if row["walls"] == "slab0.1":
        materials = {
            name: material({"name": name, "thickness_m": 0.1}) for name in ("concrete", "metal")
        }
    radio = radio_scene(scene, F, materials)
    paths = trace_paths(radio, tree, [[float(row[axis]) for axis in "xyz"]])
    exact = row["peer"] == "exact"
    if exact:
        assert len(paths) == int(row["n_paths"])
    dipole = make_antenna("dipole", F)
    for column, kind, dipoles in (("iso_theta", "isotropic_theta", 1), ("hwd", "dipole", 2)):
        receiver = make_antenna(kind, F)
        g = path_gains(radio, paths, transmitter=dipole, receiver=receiver).gain
        g = g * (THEIR_DIPOLE_GAIN / OUR_DIPOLE_GAIN) ** (0.5 * dipoles)
        for name, power in (
            ("coherent", np.abs(g.sum()) ** 2),
            ("power", np.sum(np.abs(g) ** 2)),
        ):
            dbm = 10.0 * np.log10(power) + 30.0
            expected = float(row[f"{column}_{name}_dBm"])
            assert dbm == pytest.approx(expected, abs=0.001 if exact else 0.2)
