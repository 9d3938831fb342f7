"""Octant beside Sionna RT, DiffeRT and pyroomacoustics on the same workloads, in one run.

    python benchmarks/bench_peers.py                             Octant alone
    python benchmarks/bench_peers.py --peers --workloads W1,W3   beside the peers

Octant's time is everything from the mesh in memory to the map: image search, exact paths, vector
fields, coherent power and power sum. With ``--peers`` each peer gets a virtual environment of its
own (``--envs``), and runs alternate: one of Octant, one of each peer, and again; the best of each
counts, after a run to warm up. Trust the ratios, not the seconds; on a machine that others use,
those of the seconds of all cores ("cpu").
"""

import argparse
import json
import os
import tempfile
from pathlib import Path

import numpy as np
from environments import PEERS, Peer, default_folder
from workloads import (
    FREQUENCY_HZ,
    MESHES,
    SOURCE_M,
    WALL_THICKNESS_M,
    WORKLOADS,
    best_of,
    octant_map,
    octant_paths,
    peak_mib,
    timed,
    workload_scene,
)

from octant.em.constants import VACUUM_PERMITTIVITY_F_PER_M

LENGTH_TOLERANCE_M = 1e-3
MOST_CANDIDATES = 12_000_000
"""Bounds the memory of Sionna RT, which holds ten candidates or so for a path that it keeps."""
SLOW_RUN_S = 20.0
"""A run longer than this is not repeated as often."""


def alone(names, *, walls, repetitions):
    """Print the table of Octant by itself."""
    print(f"{os.cpu_count()} cores; from the mesh to both maps, fields included; best of several")
    print("workload  receivers     paths      exact  seconds     cpu  million paths/s  peak MiB")
    for name in names:
        workload = WORKLOADS[name]
        scene, radio = workload_scene(workload, walls)

        def work(workload=workload, scene=scene, radio=radio):
            return octant_map(workload, scene, radio)

        first, _ = timed(work)
        seconds, found = best_of(1 if first[0] > SLOW_RUN_S else repetitions, work)
        paths = int(found.path_count.sum())
        known = workload.exact_paths
        right = "-" if known is None else "yes" if known == paths else f"NO: {known}"
        print(
            f"{name:8s}  {workload.side**2:9d} {paths:9d} {right:>10s}  {seconds[0]:7.3f}"
            f" {seconds[1]:7.3f}  {paths / seconds[0] / 1e6:15.2f}  {peak_mib(work):8.1f}"
        )


def describe(workload, scene, radio, folder):
    """Write what the peers need to know of a workload, and return the file."""
    corners = [
        _corners(scene.facets.outline_room_m(i)) for i in range(len(scene.facets.facet_plane))
    ]
    materials = {
        name: {
            "eps_r": (eps := m.relative_permittivity(FREQUENCY_HZ)).real,
            "sigma_s_per_m": -eps.imag * 2.0 * np.pi * FREQUENCY_HZ * VACUUM_PERMITTIVITY_F_PER_M,
            "thickness_m": m.thickness_m,
        }
        for name, m in zip(scene.material_names, radio.materials, strict=True)
    }
    description = {
        "name": workload.name,
        "is_map": workload.is_map,
        "order": workload.order,
        "side": workload.side,
        "frequency_hz": FREQUENCY_HZ,
        "source_m": SOURCE_M,
        "receivers_m": workload.receivers_m.tolist(),
        "bodies": [{"file": str(MESHES / f), "material": name} for f, name in workload.meshes],
        "materials": materials,
        "polygons": [p for p in (_outward(polygon, scene) for polygon in corners) if p],
        "samples": workload.samples,
        "most_paths": min(max(1_000_000, 10 * (workload.exact_paths or 0)), MOST_CANDIDATES),
    }
    file = folder / f"{workload.name}.json"
    file.write_text(json.dumps(description))
    return file


def _corners(edges_m):
    """Return the corners of a facet of one outline in their order around it, from its edges."""
    follows = {tuple(start): tuple(end) for start, end in edges_m.round(9).tolist()}
    corners = [next(iter(follows))]
    while follows[corners[-1]] != corners[0]:
        corners.append(follows[corners[-1]])
    return np.array(corners)


def _outward(outline, scene):
    """Return a polygon turned so that its normal points out of the air, or None without air."""
    a, b, c = outline[:3]
    normal = np.cross(b - a, c - b)
    within = a + 1e-3 * (b - a) + 1e-3 * (outline[-1] - a)
    sides = within + 1e-3 * np.array([[1.0], [-1.0]]) * normal / np.linalg.norm(normal)
    air = scene.inside_room(sides) & ~scene.inside_solid(sides)
    if not air.any():
        return None
    return (outline[::-1] if air[0] else outline).tolist()


def beside(name, peers, *, walls, repetitions, folder, envs):
    """Print the rows of one workload: Octant, then each peer."""
    workload = WORKLOADS[name]
    scene, radio = workload_scene(workload, walls)
    file = describe(workload, scene, radio, folder)
    running = {peer: Peer(peer, str(file), envs) for peer in workload.peers if peer in peers}
    ours, found = timed(lambda: octant_map(workload, scene, radio))
    best = {peer: process.run() for peer, process in running.items()}
    slow = {peer for peer, spent in best.items() if spent[0] > SLOW_RUN_S}
    for repetition in range(repetitions):
        seconds, _ = timed(lambda: octant_map(workload, scene, radio))
        ours = np.minimum(ours, seconds) if repetition else seconds
        for peer in running.keys() - slow:
            spent = running[peer].run()
            best[peer] = np.minimum(best[peer], spent) if repetition else spent
    paths = int(found.path_count.sum())
    print(
        f"{name:8s} {'Octant':15s} {ours[0]:8.3f} {ours[1]:8.3f} {'':17s} {paths:9d}"
        f" {paths / ours[0] / 1e6:10.2f} million paths/s",
        flush=True,
    )
    reference = None if workload.is_map else octant_paths(workload, scene, radio)
    inside = scene.inside_solid(workload.receivers_m)
    for peer, process in running.items():
        results = folder / f"{name}.{peer}.npz"
        process.save(results)
        process.close()
        told = compared(reference, dict(np.load(results)), inside)
        wall, cpu = best[peer][:2] / ours
        print(
            f"{name:8s} {PEERS[peer][0]:15s} {best[peer][0]:8.3f} {best[peer][1]:8.3f}"
            f" {wall:7.1f}x {cpu:7.1f}x {told}  {best[peer][2]:6.0f} MiB",
            flush=True,
        )


def compared(ours, theirs, inside):
    """Return what a row says of a peer's results; ``inside``: receivers within an object."""
    if ours is None:
        return f"{'-':>9s} {'-':>9s}  noise {theirs['noise_db']:.2f} dB rms"
    count = len(theirs["receiver"])
    words = f"{count:9d} {100.0 * count / len(ours['receiver']):8.2f}%  "
    words += verdict(ours, unmatched(ours, theirs), inside)
    if "gain" in theirs:
        power = [coherent(paths, len(inside)) for paths in (ours, theirs)]
        both = (power[0] > 0.0) & (power[1] > 0.0)
        off_db = 10.0 * np.log10(power[1][both] / power[0][both])
        words += f", coherent power {np.sqrt(np.mean(off_db**2)):.3f} dB rms"
        words += f" (median {np.median(np.abs(off_db)):.4f})"
    if "kernel_seconds" in theirs:
        words += f", its kernel alone {float(theirs['kernel_seconds']):.3f} s"
    return words


def verdict(ours, strange, inside):
    """Return what there is to say of their paths that none of ours is left for."""
    hidden = [path for path in strange if inside[path[0]]]
    twice, new = [], []
    for receiver, length in strange:
        near = np.abs(ours["length_m"][ours["receiver"] == receiver] - length) <= LENGTH_TOLERANCE_M
        if not inside[receiver]:
            (twice if near.any() else new).append(f"receiver {receiver}: {length:.4f} m")
    words = "all matched" if not new else f"{len(new)} that Octant lacks: {', '.join(new[:5])}"
    if twice:
        words += f", {len(twice)} of a length that it found more often"
    if hidden:
        words += f", {len(hidden)} to receivers inside an object"
    return words


def coherent(paths, count):
    """Return |sum of the gains|^2 of each receiver [-]."""
    field = np.zeros(count, np.complex128)
    np.add.at(field, paths["receiver"], paths["gain"])
    return np.abs(field) ** 2


def unmatched(ours, theirs):
    """Return receiver and length of each of their paths that no path of ours equals to 1 mm.

    One path of ours matches one of theirs. Both are walked through in order of length.
    """
    mine, other = (np.lexsort((p["length_m"], p["receiver"])) for p in (ours, theirs))
    a = list(zip(ours["receiver"][mine].tolist(), ours["length_m"][mine].tolist(), strict=True))
    b = list(
        zip(theirs["receiver"][other].tolist(), theirs["length_m"][other].tolist(), strict=True)
    )
    missing, i = [], 0
    for receiver, length in b:
        while i < len(a) and a[i] < (receiver, length - LENGTH_TOLERANCE_M):
            i += 1
        if i < len(a) and a[i][0] == receiver and a[i][1] <= length + LENGTH_TOLERANCE_M:
            i += 1
        else:
            missing.append((receiver, length))
    return missing


def main():
    """Read the command line and run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--peers", action="store_true", help="beside the peers")
    parser.add_argument("--only", default=",".join(PEERS), help="which peers")
    parser.add_argument("--workloads", default="", help="for example W1,W3; default: all")
    parser.add_argument("--walls", choices=WALL_THICKNESS_M, default="halfspace")
    parser.add_argument("--repetitions", type=int, default=3)
    parser.add_argument("--envs", type=Path, default=default_folder())
    arguments = parser.parse_args()
    given = [name for name in arguments.workloads.split(",") if name]
    if not arguments.peers:
        alone(given or WORKLOADS, walls=arguments.walls, repetitions=arguments.repetitions)
        return
    print(f"{os.cpu_count()} cores; runs alternate; best of {arguments.repetitions} after one")
    print("workload who              seconds      cpu    ratio cpu ratio     paths  complete")
    with tempfile.TemporaryDirectory() as folder:
        for name in given or [w.name for w in WORKLOADS.values() if w.peers]:
            beside(
                name,
                arguments.only.split(","),
                walls=arguments.walls,
                repetitions=arguments.repetitions,
                folder=Path(folder),
                envs=arguments.envs,
            )


if __name__ == "__main__":
    main()
