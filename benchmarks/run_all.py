"""All workloads in one run, as the one table that docs/evidence/benchmarks.md includes.

    python benchmarks/run_all.py                  all of it, and docs/evidence/benchmarks_table.txt
    python benchmarks/run_all.py --peers          the same beside the peers (see bench_peers.py)
    python benchmarks/run_all.py --quick          small ones, counts checked; writes no file

Seconds are those of all cores. Kernels are compiled before the clock starts. The exit code is 1
where a count is not what it is known to be; nothing is ever said about a time.
"""

import argparse
import contextlib
import importlib.metadata
import io
import os
import platform
import resource
import sys
import tempfile
from pathlib import Path

from bench_peers import beside
from buildings import building, dense_places
from environments import PEERS, default_folder
from workloads import FREQUENCY_HZ, WORKLOADS, best_of, octant_map, timed, workload_scene

from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.search.candidates import Candidates
from octant.em.search.edges import search_edges
from octant.em.search.images import search_images
from octant.em.search.rays import ray_search
from octant.geometries.wedges import find_wedges

TABLE = Path(__file__).resolve().parents[1] / "docs" / "evidence" / "benchmarks_table.txt"
QUICK = ("W1", "W3")
BUILDINGS = (10_000, 30_000, 85_000, 300_000)
QUICK_BUILDINGS = (3_000, 6_000)
DENSE_ORDER, QUICK_ORDER = 3, 2
RAYS = 1_000_000


def versions():
    """Return what the table was made with."""
    names = ("octant", "numpy", "numba", "scipy")
    words = [f"{name} {importlib.metadata.version(name)}" for name in names if _installed(name)]
    return ", ".join((f"Python {platform.python_version()}", *words, f"{os.cpu_count()} cores"))


def _installed(name):
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        return bool(importlib.metadata.version(name))
    return False


def peak_gib():
    """Return the most memory that the process has held [GiB]; the system counts in KiB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def maps(names, repetitions):
    """Yield the lines of the workloads of the peers, and whether each count is right."""
    yield "workload  receivers      paths   known      cpu s   against W1, by path", True
    first = None
    for name in names:
        workload = WORKLOADS[name]
        scene, radio = workload_scene(workload)
        octant_map(workload, scene, radio)

        def work(workload=workload, scene=scene, radio=radio):
            return octant_map(workload, scene, radio)

        seconds, found = best_of(repetitions, work)
        paths = int(found.path_count.sum())
        first = first or seconds[1] / paths
        right = workload.exact_paths in (None, paths)
        known = "-" if workload.exact_paths is None else "right" if right else "WRONG"
        share = seconds[1] / paths / first
        yield (
            f"{name:8}{workload.side**2:11,}{paths:11,}{known:>8}{seconds[1]:11.3f}{share:22.2f}",
            right,
        )


def dense(sizes, max_order):
    """Yield the lines of workload W6, and whether rays found nothing that the search lacks."""
    yield (
        (
            "triangles  facets  order   images kept   paths  rays find   search     trace"
            "   search, by triangle   GiB"
        ),
        True,
    )
    first = {}
    for size in sizes:
        scene = building(size)
        triangles = sum(len(body.faces) for body in scene.bodies)
        wedges = find_wedges(scene)
        radio = radio_scene(scene, FREQUENCY_HZ, wedges=wedges)
        source, receivers = dense_places(scene)
        begin = f"{triangles:9,}{len(scene.facets.facet_plane):8,}"
        for order in range(1, max_order + 1):
            spent, tree = timed(
                lambda s=scene, p=source, n=order, m=receivers: search_images(
                    s, p, n, receivers_m=m
                )
            )
            images = Candidates(images=tree)
            traced, paths = timed(lambda r=radio, c=images, p=receivers: trace_paths(r, c, p))
            found = ray_search(scene, source, order, rays=RAYS).tree
            met = trace_paths(radio, Candidates(images=found), receivers)
            each = spent[1] / triangles
            first.setdefault(order, each)
            yield (
                (
                    f"{begin}{order:7}{len(tree.image_m):14,}{len(paths):8,}{len(met):11,}"
                    f"{spent[1]:9.2f}{traced[1]:10.2f}{each / first[order]:22.2f}{peak_gib():6.2f}"
                ),
                bool(_holds(paths, met)),
            )
        tree = search_images(scene, source, 1)
        spent, edges = timed(lambda s=scene, w=wedges, t=tree: search_edges(s, w, t))
        both = Candidates(images=tree, edges=edges)
        traced, paths = timed(lambda r=radio, c=both, p=receivers: trace_paths(r, c, p))
        each = spent[1] / triangles
        first.setdefault("edge", each)
        yield (
            (
                f"{begin} 1+edge{edges.kept:14,}{len(paths):8,}{'-':>11}{spent[1]:9.2f}"
                f"{traced[1]:10.2f}{each / first['edge']:22.2f}{peak_gib():6.2f}"
            ),
            True,
        )


def _holds(paths, others):
    """Return whether each of the others is among the paths, by receiver and length to 1 um."""
    mine = {(r, round(x, 6)) for r, x in zip(paths.receiver, paths.length_m, strict=True)}
    near = (-1e-6, 0.0, 1e-6)
    return all(
        any((r, round(x + d, 6)) in mine for d in near)
        for r, x in zip(others.receiver, others.length_m, strict=True)
    )


def peers(repetitions):
    """Return the lines of `bench_peers.py --peers`."""
    told = io.StringIO()
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(told):
        print("workload who              seconds      cpu    ratio cpu ratio     paths  complete")
        for workload in WORKLOADS.values():
            if workload.peers:
                beside(
                    workload.name,
                    tuple(PEERS),
                    walls="halfspace",
                    repetitions=repetitions,
                    folder=Path(folder),
                    envs=default_folder(),
                )
    return told.getvalue().splitlines()


def main():
    """Run, print, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="small workloads, no file")
    parser.add_argument("--peers", action="store_true", help="beside the peers as well")
    parser.add_argument("--repetitions", type=int, default=3)
    arguments = parser.parse_args()
    lines, right = [versions(), ""], True
    warm_up = building(QUICK_BUILDINGS[0])
    for limit in (10**9, -1):
        compile_all(warm_up, limit)
    parts = (
        maps(QUICK if arguments.quick else WORKLOADS, arguments.repetitions),
        dense(
            QUICK_BUILDINGS if arguments.quick else BUILDINGS,
            QUICK_ORDER if arguments.quick else DENSE_ORDER,
        ),
    )
    print(lines[0], flush=True)
    for part in parts:
        for line, as_known in part:
            print(line, flush=True)
            lines.append(line)
            right = right and as_known
        lines.append("")
    if arguments.peers:
        lines += peers(arguments.repetitions)
    if not arguments.quick:
        TABLE.write_text("\n".join(lines).rstrip() + "\n")
        print(f"written: {TABLE}")
    if not right:
        sys.exit("a count is not what it is known to be")


def compile_all(scene, limit):
    """Compile what workload W6 needs; ``limit``: facets beyond which a scene counts as dense."""
    from octant.em.search import images

    usual, images.DENSE_FACETS = images.DENSE_FACETS, limit
    source, receivers = dense_places(scene)
    wedges = find_wedges(scene)
    tree = search_images(scene, source, 1, receivers_m=receivers)
    both = Candidates(images=tree, edges=search_edges(scene, wedges, tree))
    trace_paths(radio_scene(scene, FREQUENCY_HZ, wedges=wedges), both, receivers[:2])
    ray_search(scene, source, 1, rays=1000)
    images.DENSE_FACETS = usual


if __name__ == "__main__":
    main()
