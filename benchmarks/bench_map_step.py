"""How long the map navigator takes for one step: 2,000 particles, four tags, eight antennas.

    python benchmarks/bench_map_step.py

The field of each tag is a sum of 25 plane waves, received by antennas that look outwards; the robot
drives through it with 1 dB of noise. Printed is the processor time of a step, the least of several
rounds.
"""

import time

import numpy as np

from octant.em.power.field_maps import FieldMap
from octant.navigation.navigators.interface import Odometry
from octant.navigation.navigators.pose_particles import PoseFilter

TAGS, ANTENNAS, HEADINGS, WAVES = 4, 8, 64, 25
LOW_M, HIGH_M, PLACES, NODES = 0.2, 5.2, 240, 42
WAVELENGTH_M, RADIUS_M = 0.125, 0.1
STEP_M, TURN_RAD = 0.04, 0.03
STEPS, ROUNDS = 20, 5


def field_map(rng):
    """Return the map of all tags, in levels of a quarter of a decibel."""
    x = np.linspace(LOW_M, HIGH_M, PLACES)
    wavenumber = 2.0 * np.pi / WAVELENGTH_M
    heading = 2.0 * np.pi * np.arange(HEADINGS) / HEADINGS
    levels = np.empty((TAGS, PLACES, PLACES, 1, HEADINGS), dtype=np.uint8)
    for tag in range(TAGS):
        angle = rng.uniform(0.0, 2.0 * np.pi, WAVES)
        size = rng.standard_normal(WAVES) + 1j * rng.standard_normal(WAVES)
        east = np.exp(1j * wavenumber * np.outer(x, np.cos(angle)))
        north = np.exp(1j * wavenumber * np.outer(x, np.sin(angle)))
        off = heading - angle[:, None]
        pattern = 0.5 * (1.0 + np.cos(off)) * np.exp(1j * wavenumber * RADIUS_M * np.cos(off))
        power = np.abs((size * east[:, None] * north).reshape(-1, WAVES) @ pattern) ** 2
        codes = np.clip(255.0 + 40.0 * np.log10(power / power.max()), 1.0, 255.0)
        levels[tag] = codes.reshape(PLACES, PLACES, 1, HEADINGS)
    nodes = np.linspace(LOW_M, HIGH_M, NODES)
    return FieldMap(
        x_m=x,
        y_m=x,
        levels=levels,
        node_x_m=nodes,
        node_y_m=nodes,
        means=np.full((TAGS, NODES, NODES, 1, HEADINGS), 200, dtype=np.uint8),
        ring=np.zeros(ANTENNAS, dtype=np.int64),
        shift_rad=-2.0 * np.pi * np.arange(ANTENNAS) / ANTENNAS,
        top_dbm=np.full(TAGS, -40.0),
    )


def drive(pose_filter, belief, pose, rng):
    """Return the belief and the true pose after some steps, and the processor time of one [s]."""
    spent = 0.0
    for _ in range(STEPS):
        pose = pose + np.array([STEP_M * np.cos(pose[2]), STEP_M * np.sin(pose[2]), TURN_RAD])
        rss = np.array([pose_filter.maps.rss_w(pose[None], tag=tag)[0] for tag in range(TAGS)])
        rss *= 10.0 ** (0.1 * rng.standard_normal(rss.shape))
        begin = time.process_time()
        odometry = Odometry(distance_m=STEP_M, turn_rad=TURN_RAD, contact=False)
        belief = pose_filter.observed(pose_filter.moved(belief, odometry, rng), rss, rng)
        spent += time.process_time() - begin
    return belief, pose, spent / STEPS


def main() -> None:
    """Print the table."""
    rng = np.random.default_rng(3)
    pose = np.array([1.0, 2.0, 0.3])
    pose_filter = PoseFilter(
        maps=field_map(rng),
        shares=np.full(TAGS, 0.05),
        floors_w=np.full(TAGS, 1e-12),
        low_m=np.full(2, LOW_M),
        high_m=np.full(2, HIGH_M),
        blocked=None,
        wavelength_m=WAVELENGTH_M,
        noise_db=1.0,
        fading_db=np.full(TAGS, 5.57),
    )
    belief, pose, _ = drive(pose_filter, pose_filter.start(rng, pose=pose), pose, rng)
    steps = []
    for _ in range(ROUNDS):
        belief, pose, spent = drive(pose_filter, belief, pose, rng)
        steps.append(spent)
    off_m = np.hypot(*(pose_filter.estimate(belief).pose - pose)[:2])
    print(f"{len(belief.weights)} particles, {TAGS} tags, {ANTENNAS} antennas")
    print(f"a step: {1e3 * min(steps):.1f} ms; at the end the pose is off by {1e3 * off_m:.1f} mm")


if __name__ == "__main__":
    main()
