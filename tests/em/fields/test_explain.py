"""Budgets add up to the gains that the path kernels give, and their lines are the textbook's."""

import math

import numpy as np
import pytest

from octant.em.antennas.kinds import Antenna, make_antenna
from octant.em.fields.explain import explain_path
from octant.em.fields.gains import path_gains
from octant.em.medium.materials import material
from octant.em.medium.radio_scene import radio_scene
from octant.em.paths.tracing import trace_paths
from octant.em.search.candidates import Candidates, SolverSettings, search_candidates
from octant.em.search.images import search_images
from octant.geometries.bodies import Body
from octant.geometries.errors import GeometryError
from octant.geometries.furniture import box, cabinet
from octant.geometries.rooms import box_room
from octant.geometries.scene import build_scene
from octant.geometries.wedges import find_wedges

F = 2.4e9
WAVELENGTH = 299_792_458.0 / F
SOURCE = (3.5, 2.0, 2.9)
PLACES = [(1.213, 4.381, 0.3), (0.537, 0.623, 1.7), (2.9, 2.0, 0.4)]


@pytest.fixture(scope="module")
def radio():
    """Half-spaces, slabs, a conductor, and a cabinet that stands askew."""
    walls = {"walls": "concrete", "floor": "pec", "ceiling": "board"}
    scene = build_scene(
        box_room((5.0, 5.0, 3.0), materials=walls),
        objects=[
            cabinet(position_m=(1.75, 2.2, 0.0), yaw_deg=20.0),
            box((0.3, 0.4, 0.5), material="glass", position_m=(4.0, 4.0, 0.0)),
        ],
    )
    return radio_scene(scene, F, {"board": material({"name": "wood", "thickness_m": 0.02})})


@pytest.fixture(scope="module")
def traced(radio):
    return trace_paths(radio, Candidates(images=search_images(radio.scene, SOURCE, 3)), PLACES)


def circular():
    """A table of a field that no wire has: both components, out of phase everywhere."""
    theta = np.linspace(0.0, np.pi, 61)[:, None]
    phi = np.arange(120) * (np.pi / 60)
    pattern = np.stack(
        (np.cos(0.5 * theta) ** 2 + 0 * phi, 1j * np.cos(0.5 * theta) ** 2 + 0 * phi)
    )
    return Antenna(
        kind="pattern",
        length_m=0.0,
        frequency_hz=F,
        axis=(1, 2, 3),
        pattern=pattern * np.exp(1j * phi),
    )


ANTENNAS = {
    "dipole": make_antenna("dipole", F),
    "tilted": make_antenna("dipole", F, axis=(1, -2, 0.5)),
    "isotropic": make_antenna("isotropic_theta", F),
    "table": circular(),
}


@pytest.mark.parametrize("sender", ANTENNAS)
@pytest.mark.parametrize("taker", ["dipole", "tilted", "table"])
def test_every_budget_adds_up_to_the_gain_of_its_path(radio, traced, sender, taker):
    ends = {"transmitter": ANTENNAS[sender], "receiver": ANTENNAS[taker]}
    gains = path_gains(radio, traced, **ends)
    assert traced.order.max() == 3
    for path in range(0, len(traced), 3):
        budget = explain_path(radio, traced, path, **ends)
        assert len(budget.lines) == traced.order[path] + 4
        total = sum(line.change_db for line in budget.lines)
        gain_db = 10.0 * math.log10(abs(gains.gain[path]) ** 2)
        if gain_db < -300.0:  # opposite hands of circular fields: what is left is rounding
            assert total < -300.0
            continue
        assert total == pytest.approx(gain_db, abs=1e-9)
        assert budget.gain_db == pytest.approx(gain_db, abs=1e-9)
        assert abs(budget.gain - gains.gain[path]) <= 1e-11 * abs(gains.gain[path])
        assert budget.length_m == pytest.approx(gains.length_m[path], rel=1e-15)


LAYERED = material(
    {
        "layers": [
            {"name": "plasterboard", "thickness_m": 0.0125},
            {"name": "air", "thickness_m": 0.05},
            {"name": "wood", "thickness_m": 0.02},
        ]
    }
)


@pytest.mark.parametrize("sender", ["tilted", "table"])
def test_budgets_over_edges_and_through_sheets_add_up(sender):
    sheet = Body(
        name="sheet",
        vertices_m=np.array([(0.9, 0.4, 0.3), (1.1, 2.6, 0.2), (1.0, 2.5, 2.2), (0.8, 0.5, 2.1)]),
        faces=np.array([[0, 1, 2], [0, 2, 3]]),
        material="layered",
    )
    block = box((0.7, 0.4, 0.9), material="lined", position_m=(2.0, 1.2, 0.5), yaw_deg=15.0)
    scene = build_scene(box_room((4.0, 3.0, 2.5), material="layered"), objects=(block, sheet))
    lined = material({"layers": [{"name": "wood", "thickness_m": 0.02}, {"name": "concrete"}]})
    radio = radio_scene(
        scene,
        F,
        {"layered": LAYERED, "lined": lined},
        transmission=True,
        wedges=find_wedges(scene),
    )
    candidates = search_candidates(
        radio,
        (0.4, 0.7, 0.9),
        SolverSettings(max_reflections=2, diffraction=True, max_diffractions=2),
    )
    paths = trace_paths(
        radio,
        candidates,
        [(3.3, 2.2, 1.6), (0.5, 2.3, 0.7), (1.5, 1.6, 1.2)],
    )
    ends = {"transmitter": ANTENNAS[sender], "receiver": ANTENNAS["tilted"]}
    gains = path_gains(radio, paths, **ends)
    words = set()
    for path in range(len(paths)):
        budget = explain_path(radio, paths, path, **ends)
        word = "".join(paths.letters_of(path))
        words.add(word)
        assert len(budget.lines) == len(word) + 4 - word.count("DD")
        total = sum(line.change_db for line in budget.lines)
        if abs(gains.gain[path]) < 1e-10:
            continue
        gain_db = 10.0 * math.log10(abs(gains.gain[path]) ** 2)
        assert total == pytest.approx(gain_db, abs=1e-9)
        assert abs(budget.gain - gains.gain[path]) <= 1e-10 * abs(gains.gain[path])
    assert {"D", "DD", "T", "TR", "R"} <= words
    assert any({"D", "T"} <= set(word) for word in words)


def test_losses_lie_between_those_of_te_and_tm(radio, traced):
    ends = {"transmitter": ANTENNAS["tilted"], "receiver": ANTENNAS["dipole"]}
    seen = 0
    for path in range(len(traced)):
        for line in explain_path(radio, traced, path, **ends).lines:
            if line.step != "reflection":
                continue
            seen += 1
            limits = sorted(20.0 * math.log10(abs(c)) for c in (line.te, line.tm))
            assert limits[0] - 1e-9 <= line.change_db <= limits[1] + 1e-9
            assert 0.0 <= line.te_share <= 1.0
            mixed = line.te_share * abs(line.te) ** 2 + (1 - line.te_share) * abs(line.tm) ** 2
            assert line.change_db == pytest.approx(10.0 * math.log10(mixed), abs=1e-9)
    assert seen > 100


def test_line_of_sight_is_friis():
    radio = radio_scene(build_scene(()), F)
    tree = search_images(radio.scene, (0, 0, 2), 0, region_m=[(-9, -9, -9), (9, 9, 9)])
    paths = trace_paths(radio, Candidates(images=tree), [(3.0, 4.0, 2.0)])
    ends = {"transmitter": ANTENNAS["dipole"], "receiver": ANTENNAS["dipole"]}
    lines = {line.step: line.change_db for line in explain_path(radio, paths, 0, **ends).lines}
    assert lines == {
        "transmitter": pytest.approx(2.15088, abs=1e-5),
        "free space": pytest.approx(20 * math.log10(WAVELENGTH / (4 * math.pi * 5.0)), abs=1e-12),
        "polarisation": pytest.approx(0.0, abs=1e-9),
        "receiver": pytest.approx(2.15088, abs=1e-5),
    }


def test_crossed_dipoles_lose_everything_in_polarisation():
    radio = radio_scene(build_scene(()), F)
    tree = search_images(radio.scene, (0, 0, 2), 0, region_m=[(-9, -9, -9), (9, 9, 9)])
    paths = trace_paths(radio, Candidates(images=tree), [(4.0, 0.0, 2.0)])
    across = make_antenna("dipole", F, axis=(0, 1, 0))
    budget = explain_path(radio, paths, 0, transmitter=ANTENNAS["dipole"], receiver=across)
    lines = {line.step: line.change_db for line in budget.lines}
    assert lines["polarisation"] < -300.0
    assert lines["receiver"] == pytest.approx(2.15088, abs=1e-5)
    tilted = make_antenna("dipole", F, axis=(0, 1, 1))
    budget = explain_path(radio, paths, 0, transmitter=ANTENNAS["dipole"], receiver=tilted)
    lines = {line.step: line.change_db for line in budget.lines}
    assert lines["polarisation"] == pytest.approx(-10 * math.log10(2.0), abs=1e-9)


def test_a_null_of_the_transmitter_is_minus_infinity_and_nothing_else_is(radio):
    """Straight below a vertical dipole nothing is sent; nor straight up to the ceiling."""
    tree = search_images(radio.scene, SOURCE, 1)
    paths = trace_paths(radio, Candidates(images=tree), [(3.5, 2.0, 0.4)])
    ceiling = [
        p
        for p in range(len(paths))
        if paths.order[p] == 1 and np.ptp(paths.vertices_of(p)[:, :2], axis=0).max() < 1e-12
    ]
    ends = {"transmitter": ANTENNAS["dipole"], "receiver": ANTENNAS["dipole"]}
    budget = explain_path(radio, paths, ceiling[0], **ends)
    assert budget.gain_db == -math.inf
    lines = [line.change_db for line in budget.lines]
    assert lines[0] == -math.inf
    assert lines[2] == lines[3] == 0.0
    assert not any(math.isnan(change) for change in lines)


def test_a_path_that_does_not_exist_is_refused(radio, traced):
    ends = {"transmitter": ANTENNAS["dipole"], "receiver": ANTENNAS["dipole"]}
    with pytest.raises(GeometryError, match="numbered 0 to"):
        explain_path(radio, traced, len(traced), **ends)
