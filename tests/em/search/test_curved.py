"""Curved bodies by flat panels, against geometrical optics, and that against the exact series."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import h2vp, hankel2, jv, jvp

from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.search.candidates import Candidates
from octant.em.search.images import search_images
from octant.geometries.furniture import cylinder, sphere
from octant.geometries.scene import build_scene

F = 2.4e9
WAVELENGTH = 299792458.0 / F


def specular_angle(bearing, source, receiver, radius):
    """Angle [rad] of the point on a circle that mirrors the source to a receiver at a bearing."""
    low, high = np.zeros_like(bearing), bearing.copy()
    for _ in range(60):
        angle = 0.5 * (low + high)
        point = radius * np.stack((np.cos(angle), np.sin(angle)), axis=-1)
        normal = point / radius
        to_source = np.array([source, 0.0]) - point
        to_receiver = receiver * np.stack((np.cos(bearing), np.sin(bearing)), -1) - point
        tangent = np.stack((-normal[..., 1], normal[..., 0]), axis=-1)
        sines = [
            np.sum(d * tangent, axis=-1) / np.linalg.norm(d, axis=-1)
            for d in (to_source, to_receiver)
        ]
        early = sines[0] + sines[1] > 0.0  # the mirror point lies further towards the receiver
        low, high = np.where(early, angle, low), np.where(early, high, angle)
    return angle


def smooth_power(bearing, source, receiver, radius, *, curved_both_ways):
    """Mean power gain by geometrical optics: isotropic ends, all in one plane, a PEC body.

    The reflected wave has the curvatures 1/s and 1/s + 2 / (a cos) in the plane of incidence, and
    across it 1/s for a cylinder, 1/s + 2 cos / a for a sphere (Balanis 1989, equations 13-37a, b).
    """
    angle = specular_angle(np.abs(bearing), source, receiver, radius)
    point = radius * np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    inward = np.array([source, 0.0]) - point
    outward = (
        receiver * np.stack((np.cos(np.abs(bearing)), np.sin(np.abs(bearing))), axis=-1) - point
    )
    s, r = np.linalg.norm(inward, axis=-1), np.linalg.norm(outward, axis=-1)
    cosine = np.sum(inward * point, axis=-1) / (s * radius)
    in_plane = 1.0 / (1.0 / s + 2.0 / (radius * cosine))
    across = 1.0 / (1.0 / s + (2.0 * cosine / radius if curved_both_ways else 0.0))
    spreading = in_plane / (in_plane + r) * across / (across + r)
    return (WAVELENGTH / (4.0 * np.pi)) ** 2 / s**2 * spreading


def single_bounces(body, source, receivers):
    """Receiver and power gain between isotropic ends of each reflection off a PEC body's panels."""
    scene = build_scene((), objects=(body,))
    paths = trace_paths(
        radio_scene(scene, F), Candidates(images=search_images(scene, source, 1)), receivers
    )
    bounced = paths.order == 1
    return paths.receiver[bounced], (WAVELENGTH / (4 * np.pi * paths.length_m[bounced])) ** 2


RADIUS, SOURCE, RING = 0.5, 5.0, 4.0


def prism(sides, turn):
    """A tall PEC cylinder about the origin, turned by a share of one side."""
    return cylinder(
        RADIUS,
        4.0,
        material="pec",
        sides=sides,
        position_m=(0.0, 0.0, -2.0),
        yaw_deg=turn * 360.0 / sides,
    )


@pytest.mark.parametrize(("sides", "all_round", "sector"), [(24, 0.02, 0.06), (96, 0.01, 0.04)])
def test_the_mean_power_of_a_prism_is_that_of_the_smooth_cylinder(sides, all_round, sector):
    """From backscatter to 120 degrees, over all and over sectors of 30 degrees."""
    bearing = np.radians(np.linspace(-120.0, 120.0, 2401))
    ring = np.column_stack((RING * np.cos(bearing), RING * np.sin(bearing), np.zeros_like(bearing)))
    total = np.zeros(len(bearing))
    for turn in (0.0, 0.37, 0.81):
        receiver, power = single_bounces(prism(sides, turn), (SOURCE, 0.0, 0.0), ring)
        np.add.at(total, receiver, power / 3.0)
    smooth = smooth_power(bearing, SOURCE, RING, RADIUS, curved_both_ways=False)
    assert total.mean() == pytest.approx(smooth.mean(), rel=all_round)
    for part in np.array_split(np.arange(len(bearing)), 8):
        assert total[part].mean() == pytest.approx(smooth[part].mean(), rel=sector)


def test_the_power_of_a_prism_at_one_place_is_a_glint_or_nothing():
    """What the mean hides: a panel mirrors as if it were endless, or not at all."""
    bearing = np.radians(np.linspace(-60.0, 60.0, 601))
    ring = np.column_stack((RING * np.cos(bearing), RING * np.sin(bearing), np.zeros_like(bearing)))
    receiver, power = single_bounces(prism(24, 0.3), (SOURCE, 0.0, 0.0), ring)
    smooth = smooth_power(bearing, SOURCE, RING, RADIUS, curved_both_ways=False)
    assert len(np.unique(receiver)) == len(receiver)
    assert 0.05 < len(receiver) / len(bearing) < 0.3
    assert (10.0 * np.log10(power / smooth[receiver])).min() > 5.0


@pytest.mark.parametrize("subdivisions", [1, 2])
def test_the_mean_power_of_a_polyhedron_is_that_of_the_smooth_sphere(subdivisions):
    rng = np.random.default_rng(1)
    bearing, roll = np.radians(rng.uniform(-100, 100, 20000)), rng.uniform(0, 2 * np.pi, 20000)
    away = np.sin(bearing)
    places = RING * np.column_stack((np.cos(bearing), away * np.cos(roll), away * np.sin(roll)))
    body = sphere(RADIUS, material="pec", subdivisions=subdivisions)
    total = np.zeros(len(bearing))
    for _ in range(4):
        turned, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        solid = replace(body, vertices_m=body.vertices_m @ turned.T)
        receiver, power = single_bounces(solid, (SOURCE, 0.0, 0.0), places)
        np.add.at(total, receiver, power / 4.0)
    smooth = smooth_power(bearing, SOURCE, RING, RADIUS, curved_both_ways=True)
    inscribed = body.area_m2 / (4.0 * np.pi * RADIUS**2)
    assert total.mean() == pytest.approx(inscribed * smooth.mean(), rel=0.06)


@pytest.mark.parametrize(
    ("ka", "backscatter", "aside"),
    [(5, 0.12, 0.15), (10, 0.03, 0.10), (20, 0.01, 0.04), (50, 0.001, 0.006)],
)
def test_geometrical_optics_of_a_cylinder_meets_the_exact_series(ka, backscatter, aside):
    """Scattering width of a PEC cylinder in a plane wave, both polarisations, to 120 degrees.

    Exact: (4 / k) |sum eps_n c_n cos n phi|^2 with c_n = J_n / H_n or J_n' / H_n' (Balanis 1989,
    equations 11-102 and 11-117); geometrical optics: pi a cos of the angle of incidence.
    """
    n = np.arange(int(ka + 6.0 * ka ** (1.0 / 3.0) + 10.0))
    weight = np.where(n == 0, 1.0, 2.0)
    for ratio in (jv(n, ka) / hankel2(n, ka), jvp(n, ka) / h2vp(n, ka)):
        for degrees, within in ((180, backscatter), (150, aside), (120, aside)):
            phi = np.radians(degrees)  # from the direction in which the wave travels
            width = 4.0 / ka * np.abs(np.sum(weight * ratio * np.cos(n * phi))) ** 2
            assert width == pytest.approx(np.pi * np.sin(0.5 * phi), rel=within)
