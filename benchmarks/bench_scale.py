"""How scenes, searches and launched rays grow with the number of triangles.

One command: ``python benchmarks/bench_scale.py``. With the folder of the peers' meshes as its
argument it times workload W5 as well. Everything is measured side by side in this one run: trust
the ratios, not the seconds. Kernels are compiled before the clock starts.
"""

import resource
import sys
import time
from pathlib import Path

import numpy as np

from octant.em.search.images import search_images
from octant.em.search.rays import ray_search
from octant.geometries.bodies import Body
from octant.geometries.furniture import box, cabinet, cylinder
from octant.geometries.mesh_files import load_bodies
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene

SOURCE_M = (5.1, 3.3, 2.7)


def terrain(cells):
    """Return a rough floor of 2 cells^2 triangles, no two of them coplanar."""
    rng, i = np.random.default_rng(0), np.arange(cells + 1)
    x, y = np.meshgrid(i * 10.0 / cells, i * 10.0 / cells, indexing="ij")
    z = 0.3 + 0.05 * np.sin(3 * x) * np.cos(2 * y) + rng.normal(0.0, 1.0 / cells, x.shape)
    a = (i[:-1, None] * (cells + 1) + i[None, :-1]).ravel()
    b, c, d = a + cells + 1, a + cells + 2, a + 1
    faces = np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))
    vertices = np.stack((x, y, z), axis=-1).reshape(-1, 3)
    return Body(name="terrain", vertices_m=vertices, faces=faces, material="wood")


def clutter(count):
    """Return so many small boxes at odd angles."""
    rng = np.random.default_rng(0)
    return [
        box(
            rng.uniform(0.01, 0.05, 3),
            material="metal",
            position_m=rng.uniform((0.1, 0.1, 0.1), (9.8, 9.8, 2.9)),
            yaw_deg=float(rng.uniform(0.0, 90.0)),
            name=f"box{k}",
        )
        for k in range(count)
    ]


def office(cabinets, columns):
    """Return a furnished room of 10 x 7 x 3 m."""
    rng = np.random.default_rng(0)
    things = [
        cabinet(
            rng.uniform((0.3, 0.3, 0.4), (1.2, 0.6, 1.8)),
            position_m=(*rng.uniform((0.1, 0.1), (8.5, 6.2)), 0.0),
        )
        for _ in range(cabinets)
    ]
    things += [
        cylinder(
            float(rng.uniform(0.1, 0.4)),
            1.2,
            material="metal",
            sides=48,
            position_m=(*rng.uniform((0.5, 0.5), (9.0, 6.5)), 0.5),
        )
        for _ in range(columns)
    ]
    return build_scene(box_room((10.0, 7.0, 3.0)), objects=things)


def timed(work):
    """Return the seconds that some work took, and its result."""
    start = time.perf_counter()
    result = work()
    return time.perf_counter() - start, result


def scenes():
    """Print the time per triangle of building scenes."""
    print("scene               triangles  seconds  us per triangle  against the first")
    first = None
    rows = [("terrain", lambda n=n: [terrain(n)]) for n in (70, 224, 707)]
    rows += [("boxes", lambda n=n: clutter(n)) for n in (1000, 10000)]
    for name, make in rows:
        objects, room = make(), box_room((10.0, 10.0, 3.0))
        triangles = sum(len(b.faces) for b in objects)
        seconds, _ = timed(lambda r=room, o=objects: build_scene(r, objects=o))
        each = 1e6 * seconds / triangles
        first = first or each
        print(f"{name:18}{triangles:11,}{seconds:9.2f}{each:17.1f}{each / first:19.2f}")


def searches(meshes):
    """Print the images of complete searches and the time they took."""
    rows = [("11 cabinets", office(11, 0), 5), ("4 cabinets, 6 columns", office(4, 6), 3)]
    source = SOURCE_M
    if meshes:
        room = load_bodies(meshes / "room.ply", unit="m", material="concrete")
        metal = load_bodies(meshes / "w5_metal.ply", unit="m", material="metal")
        wood = load_bodies(meshes / "w5_wood.ply", unit="m", material="wood")
        rows.append(("W5", build_scene(room, objects=(*metal, *wood)), 2))
    print("\ncomplete search          planes  order    images  seconds  nothing opaque")
    for name, scene, order in rows:
        source = (3.5, 2.0, 2.9) if name == "W5" else SOURCE_M
        clear = np.zeros(len(scene.facets.facet_plane))
        seconds, tree = timed(lambda s=scene, p=source, n=order: search_images(s, p, n))
        other, _ = timed(
            lambda s=scene, p=source, n=order, c=clear: search_images(s, p, n, opaque_facets=c)
        )
        planes = len(scene.facets.plane_normal)
        print(
            f"{name:24}{planes:7,}{order:7}{len(tree.image_m):10,}{seconds:9.3f}"
            f"{other / seconds:13.1f} x"
        )


def rays():
    """Print what launched rays find in dense meshes."""
    print("\nrays, order 2        triangles  seconds  sequences   missing    at most")
    for cells in (224, 707):
        scene = build_scene(box_room((10.0, 10.0, 3.0)), objects=[terrain(cells)])
        seconds, found = timed(lambda s=scene: ray_search(s, SOURCE_M, 2))
        print(
            f"{found.rays:12,}{2 * cells**2:18,}{seconds:9.2f}{found.found.sum():11,}"
            f"{found.tree.rays.missing:10.4%}{found.tree.rays.at_most:11.4%}"
        )
    # The system counts in units of 1024 bytes.
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(f"peak memory {peak:.1f} GiB")


def main():
    """Print the tables."""
    small = build_scene(box_room((5.0, 5.0, 3.0)), objects=clutter(3))
    search_images(small, (1.0, 1.0, 1.0), 2)
    ray_search(small, (1.0, 1.0, 1.0), 2, rays=1000)
    scenes()
    searches(Path(sys.argv[1]) if len(sys.argv) > 1 else None)
    rays()


if __name__ == "__main__":
    main()
