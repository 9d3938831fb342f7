"""How long the map navigator takes for one step: 2,000 particles, four tags, eight antennas.

    python benchmarks/bench_map_step.py

At first the field of each tag is a sum of 25 plane waves, received by antennas that look outwards;
the robot drives through it with 1 dB of noise. Then it is that of dipoles at the ceiling of a
concrete room, three reflections, whose places are known to 2 cm only and searched for. Printed is
the processor time of a step, the least of several rounds.
"""

import time

import numpy as np

from octant.em.antennas.kinds import make_antenna
from octant.em.medium.radio_scene import radio_scene
from octant.em.power.field_maps import FieldMap, joined, make_field_map, plan_map
from octant.em.power.node_paths import trace_node_paths
from octant.em.power.path_maps import make_path_map
from octant.em.reader.response import sector_response
from octant.em.search.candidates import SolverSettings
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene
from octant.navigation.navigators.interface import Odometry
from octant.navigation.navigators.pose_particles import PoseFilter
from octant.navigation.navigators.tag_places import TagSurvey

TAGS, ANTENNAS, HEADINGS, WAVES = 4, 8, 64, 25
LOW_M, HIGH_M, PLACES, NODES = 0.2, 5.2, 240, 42
WAVELENGTH_M, RADIUS_M = 0.125, 0.1
CARRIER_HZ = 2.4e9
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


def drive(filter_, belief, pose, rng):
    """Return the belief and the true pose after some steps, and the processor time of one [s]."""
    spent = 0.0
    for _ in range(STEPS):
        pose = pose + np.array([STEP_M * np.cos(pose[2]), STEP_M * np.sin(pose[2]), TURN_RAD])
        rss = np.array([filter_.maps.rss_w(pose[None], tag=tag)[0] for tag in range(TAGS)])
        rss *= 10.0 ** (0.1 * rng.standard_normal(rss.shape))
        begin = time.process_time()
        odometry = Odometry(distance_m=STEP_M, turn_rad=TURN_RAD, contact=False)
        belief = filter_.observed(filter_.moved(belief, odometry, rng), rss, rng)
        spent += time.process_time() - begin
    return belief, pose, spent / STEPS


def room_filter() -> PoseFilter:
    """Return the filter of a concrete room whose tags' places are searched for."""
    size_m = HIGH_M + LOW_M
    scene = build_scene(box_room((size_m, size_m, 3.1), material="concrete"))
    radios = [radio_scene(scene, CARRIER_HZ)]
    azimuths = 2.0 * np.pi * np.arange(ANTENNAS) / ANTENNAS
    responses = [sector_response(azimuths, frequency_hz=CARRIER_HZ)]
    low, high = np.full(2, LOW_M), np.full(2, HIGH_M)
    plan = plan_map(low, high, wavelength_m=radios[0].wavelength_m)
    maps, paths = [], []
    for x, y in ((1.4, 1.1), (4.1, 1.7), (2.9, 4.3), (1.2, 3.6)):
        traced = trace_node_paths(
            radios, plan.node_x_m, plan.node_y_m, tag_position_m=np.array([x, y, 3.0]),
            tag_antennas=[make_antenna("dipole", CARRIER_HZ)], reader_z_m=0.3,
            solver=SolverSettings(max_reflections=3),
        )  # fmt: skip
        sent = {"tag_power_w": 1.0, "reader_z_m": 0.3}
        maps.append(make_field_map(traced, radios, responses, plan, **sent))
        paths.append(make_path_map(traced.strongest(), radios, responses, plan, **sent))
    sd_m = np.full((TAGS, 3), 0.02)
    survey = TagSurvey(paths=tuple(paths), sd_m=sd_m, known_m=np.zeros((TAGS, 3)), known_sd_m=sd_m)
    return pose_filter(joined(maps), share=0.02, survey=survey)


def pose_filter(maps: FieldMap, *, share: float, survey: TagSurvey | None = None) -> PoseFilter:
    """Return a filter of the pose in these maps."""
    return PoseFilter(
        maps=maps,
        shares=np.full(TAGS, share),
        floors_w=np.full(TAGS, 1e-12),
        low_m=np.full(2, LOW_M),
        high_m=np.full(2, HIGH_M),
        blocked=None,
        wavelength_m=WAVELENGTH_M,
        noise_db=1.0,
        fading_db=np.full(TAGS, 5.57),
        survey=survey,
    )


def measure(what: str, filter_: PoseFilter, rng: np.random.Generator) -> None:
    """Print what a step costs."""
    pose = np.array([2.5, 1.3, 0.0])
    belief, pose, _ = drive(filter_, filter_.start(rng, pose=pose), pose, rng)
    steps = []
    for _ in range(ROUNDS):
        belief, pose, spent = drive(filter_, belief, pose, rng)
        steps.append(spent)
    off_m = np.hypot(*(filter_.estimate(belief).pose - pose)[:2])
    print(f"{what}: {len(belief.weights)} particles, {TAGS} tags, {ANTENNAS} antennas")
    print(f"a step: {1e3 * min(steps):.1f} ms; at the end the pose is off by {1e3 * off_m:.1f} mm")


def main() -> None:
    """Print the table."""
    rng = np.random.default_rng(3)
    measure("tags where they should be", pose_filter(field_map(rng), share=0.05), rng)
    measure("places searched for", room_filter(), rng)


if __name__ == "__main__":
    main()
