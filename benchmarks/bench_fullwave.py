"""Times of the full-wave solver: unknowns, assembly, factorisation, far field, memory.

Run from a checkout with ``octant`` installed::

    python benchmarks/bench_fullwave.py [--sweep | --ratios | --robot] [--cells 10 14 20]

Each line is one design of the thesis at one mesh density, warm (a small run goes first), with and
without the reader's rotational symmetry; the exponents say how each step grows with the unknowns.
``--ratios`` sets side by side, each pair one after the other on the same machine: the far field in
every direction against few directions and interpolation, four loads by four solutions against one,
and factors in double precision against those in single precision, refined. ``--robot`` solves the
reader on a robot's body of 30 x 30 x 20 cm, on the axis and 2 cm beside it.
"""

import argparse
import itertools
import math
import resource
import time
from dataclasses import replace

import numpy as np

from octant.em.antennas.embedded import GRID_SHAPE
from octant.em.blocks import one_blas_thread
from octant.em.directions import angle_grid
from octant.em.reader.fullwave import linear_solve
from octant.em.reader.fullwave.basis import surface_basis
from octant.em.reader.fullwave.far_field import band_limited
from octant.em.reader.fullwave.mesh import reader_mesh
from octant.em.reader.fullwave.rwg import impedance_matrix
from octant.em.reader.fullwave.solve import solve_reader
from octant.geometries.furniture import box
from octant.geometries.reader_body import reader_body

FREQUENCY_HZ = 2.4e9
THETA = np.radians(np.arange(0.0, 181.0, 2.0))
COLUMNS = 72


def run(cells, *, symmetry, antenna="dipole", **body):
    """Return the times of each step for one design, with all patterns on 2 by 5 degrees."""
    clock = [time.perf_counter()]
    mesh = reader_mesh(
        reader_body(**body),
        frequency_hz=FREQUENCY_HZ,
        antenna=antenna,
        cells_per_wavelength=cells,
    )
    clock.append(time.perf_counter())
    result = solve_reader(mesh, symmetry=symmetry)
    clock.append(time.perf_counter())
    result.pattern_grid(THETA, COLUMNS)
    clock.append(time.perf_counter())
    steps = {
        "mesh": clock[1] - clock[0],
        **result.seconds,
        "patterns": clock[3] - clock[2],
        "total": clock[3] - clock[0],
    }
    return result, steps


def densities(cells):
    """Print the times of the thesis' choice at several densities, and how they grow."""
    for symmetry in (False, True):
        print(f"r_a 10 cm, h_p 8 cm, dipoles, symmetry {'used' if symmetry else 'not used'}")
        rows = []
        for count in cells:
            result, steps = run(count, symmetry=symmetry)
            rows.append((result.unknowns, steps))
            times = "  ".join(f"{name} {value:6.2f} s" for name, value in steps.items())
            print(f"  1/{count:<4g} {result.unknowns:6d} unknowns  {times}")
        for (small, before), (large, after) in itertools.pairwise(rows):
            ratio = math.log(large / small)
            growth = "  ".join(
                f"{name} {math.log(after[name] / before[name]) / ratio:4.1f}" for name in before
            )
            print(f"  exponents {small} to {large}: {growth}")
        peak_gib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        print(f"  greatest memory so far {peak_gib:.2f} GiB")


def seconds(work):
    """Return the least time of three calls, and what the last returned."""
    times = []
    for _ in range(3):
        start = time.perf_counter()
        done = work()
        times.append(time.perf_counter() - start)
    return min(times), done


def ratios():
    """Print what few directions and loads by circuit theory save, and what they are off."""
    theta, phi = angle_grid(*GRID_SHAPE)
    loads = (50.0, 75.0, 100.0, 150.0)
    for shape, radius_m in (("square", 0.10), ("round", 0.099)):
        body = reader_body(ground_plane_shape=shape, antenna_radius_m=radius_m)
        mesh = reader_mesh(body, frequency_hz=FREQUENCY_HZ)
        result = solve_reader(mesh)
        share = result.basis.sectors if result.port_step else 1
        slow, exact = seconds(
            lambda r=result, s=share: r.samples.far_field(theta[:, None], phi[: len(phi) // s])
        )
        fast, few = seconds(
            lambda r=result: band_limited(
                r.samples, sectors=r.basis.sectors, port_step=r.port_step
            ).on_grid(theta, len(phi))
        )
        off = float(np.abs(few[:, :, : exact.shape[2]] - exact).max() / np.abs(exact).max())
        print(
            f"  {shape:7s} far field: {slow:.3f} s in {theta.size * phi.size} directions, "
            f"{fast:.3f} s by few, {slow / fast:.1f} times; off by {off:.0e}"
        )
        slow, _ = seconds(
            lambda m=mesh: [
                solve_reader(m, load_ohm=load).pattern_grid(theta, len(phi)) for load in loads
            ]
        )
        fast, _ = seconds(
            lambda m=mesh: [
                replace(solved, load_ohm=load).pattern_grid(theta, len(phi))
                for solved in (solve_reader(m),)
                for load in loads
            ]
        )
        print(
            f"  {shape:7s} four loads: {slow:.2f} s solved, {fast:.2f} s, {slow / fast:.1f} times"
        )


def precisions():
    """Print what factors in single precision save where no symmetry helps, in processor time."""
    for cells in (10.0, 14.0):
        mesh = reader_mesh(reader_body(), frequency_hz=FREQUENCY_HZ, cells_per_wavelength=cells)
        basis = surface_basis(mesh.vertices_m, mesh.faces)
        matrix = impedance_matrix(basis, frequency_hz=FREQUENCY_HZ)
        right = np.random.default_rng(1).normal(size=(8, 1, len(matrix)))
        found, times = [], []
        with one_blas_thread():
            for single_from in (len(matrix) + 1, 0):
                linear_solve.SINGLE_FROM = single_from
                copy = matrix.copy()
                start = time.process_time()
                found.append(linear_solve.solve_currents(basis, copy, right))
                times.append(time.process_time() - start)
        off = float(np.abs(found[1] - found[0]).max() / np.abs(found[0]).max())
        print(
            f"  {len(matrix)} functions: {times[0]:.2f} s in double precision, {times[1]:.2f} s in "
            f"single and refined, {times[0] / times[1]:.1f} times; off by {off:.0e}"
        )


def robot():
    """Print time and memory of the reader on a robot's body, on the axis and beside it."""
    for beside_m in (0.0, 0.02):
        corner_m = (beside_m - 0.15, -0.15, -0.25)
        body = box((0.3, 0.3, 0.2), material="metal", position_m=corner_m)
        mesh = reader_mesh(reader_body(), frequency_hz=FREQUENCY_HZ, surroundings=(body,))
        start = time.process_time()
        result = solve_reader(mesh)
        spent = time.process_time() - start
        peak_gib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
        print(
            f"  {100 * beside_m:g} cm beside the axis: {result.unknowns} unknowns in "
            f"{result.basis.sectors} sectors, {spent:.1f} s of processor time, greatest memory so "
            f"far {peak_gib:.2f} GiB, power balance {result.balance_error:.0e}"
        )


def sweep():
    """Print the time of the thesis' twelve designs at the default density."""
    start = time.perf_counter()
    designs = itertools.product(("dipole", "monopole"), (0.05, 0.10), (0.0, 0.08, 0.15))
    for antenna, radius_m, height_m in designs:
        result, steps = run(
            10.0,
            symmetry=True,
            antenna=antenna,
            antenna_radius_m=radius_m,
            plate_height_m=height_m,
            monopole_plane_m=0.04 if antenna == "monopole" else 0.0,
        )
        print(
            f"  {antenna:8s} r_a {100 * radius_m:3.0f} cm  h_p {100 * height_m:3.0f} cm "
            f"{result.unknowns:6d} unknowns {steps['total']:6.2f} s  "
            f"balance {result.balance_error:.1e}"
        )
    print(f"twelve designs in {time.perf_counter() - start:.1f} s")


def main():
    """Read the command line and run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=float, nargs="+", default=[7.0, 10.0, 14.0])
    parser.add_argument("--sweep", action="store_true", help="the thesis' twelve designs")
    parser.add_argument("--ratios", action="store_true", help="what was slow against what is fast")
    parser.add_argument("--robot", action="store_true", help="the reader on a robot's body")
    arguments = parser.parse_args()
    run(5.0, symmetry=True)
    run(5.0, symmetry=False)
    if arguments.ratios:
        ratios()
        precisions()
        return
    if arguments.robot:
        robot()
        return
    densities(arguments.cells)
    if arguments.sweep:
        sweep()


if __name__ == "__main__":
    main()
