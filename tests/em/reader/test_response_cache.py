"""Laws of the cache: same numbers from disk, another key for another reader, nothing breaks."""

import concurrent.futures
import sys
import warnings
from dataclasses import replace

import numpy as np
import pytest

from octant.em.antennas.kinds import make_antenna
from octant.em.reader import cache as response_cache
from octant.em.reader.cache import CACHE_VARIABLE, cache_folder, cached_responses
from octant.em.reader.fullwave.conductor import Conductor
from octant.em.reader.fullwave.ported import ported_mesh, strip
from octant.em.reader.fullwave.response import response_of, solved_reader
from octant.em.reader.fullwave.solve import solve_reader
from octant.geometries.errors import CacheWarning, GeometryError
from octant.geometries.furniture import box
from octant.geometries.reader_body import reader_body

F = 2.4e9
SHAPE = {"antennas": 4, "plate_height_m": 0.0, "antenna_radius_m": 0.08}
COARSE = {"cells_per_wavelength": 6.0}


def body(**changes):
    return reader_body(**{**SHAPE, **changes})


@pytest.fixture(scope="module")
def solved():
    return solved_reader(body(), make_antenna("dipole", F), **COARSE)


@pytest.fixture
def calls(monkeypatch, solved):
    """Count the solutions that are asked for; each costs nothing."""
    count = []

    def counted(*arguments, **named):
        count.append((arguments, named))
        return solved

    monkeypatch.setattr(response_cache, "solved_reader", counted)
    return count


def ask(folder, frequencies_hz=(F,), *, antenna="dipole", shape=None, **changes):
    return cached_responses(
        body(**(shape or {})),
        make_antenna(antenna, F),
        frequencies_hz,
        folder=folder,
        **{**COARSE, **changes},
    )


def test_a_solution_is_solved_once_and_read_back_bit_by_bit(tmp_path, calls, solved):
    first, second = ask(tmp_path)[0], ask(tmp_path)[0]
    assert len(calls) == 1
    np.testing.assert_array_equal(second.response.pattern, first.response.pattern)
    for name in ("impedance_ohm", "input_impedance_ohm", "s_matrix", "radiated_share"):
        np.testing.assert_array_equal(getattr(second.ports, name), getattr(first.ports, name))
        np.testing.assert_array_equal(getattr(second.ports, name), getattr(solved, name))
    assert second.ports.unknowns == solved.unknowns > 100
    assert second.response.model == "fullwave"
    assert second.response.warnings == solved.warnings
    exact = response_of(solved, body())
    for name in ("pattern", "phase_centres_m", "azimuths_rad"):
        np.testing.assert_array_equal(getattr(second.response, name), getattr(exact, name))


def test_one_solution_serves_all_loads(tmp_path, calls):
    ask(tmp_path)
    load_ohm = [20.0, 50.0 - 30.0j, 80.0, 300.0]
    found = ask(tmp_path, load_ohm=load_ohm)[0]
    assert len(calls) == 1
    assert len(list(tmp_path.iterdir())) == 1
    direct = solved_reader(body(), make_antenna("dipole", F), load_ohm=load_ohm, **COARSE)
    for name in ("input_impedance_ohm", "s_matrix", "radiated_share", "accepted_share"):
        np.testing.assert_allclose(getattr(found.ports, name), getattr(direct, name), rtol=1e-9)
    expected = response_of(direct, body()).pattern
    np.testing.assert_allclose(found.response.pattern, expected, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    "change",
    [
        {"gap_m": 0.006},
        {"cells_per_wavelength": 7.0},
        {"wire_radius_m": 0.0004},
        {"feed_gap_m": 0.0},
        {"antenna": "monopole"},
        {"frequencies_hz": (2.41e9,)},
        {"shape": {"antenna_radius_m": 0.081}},
        {"shape": {"ground_plane_shape": "round"}},
        {"shape": {"ground_plane_m": 0.21}},
        {"shape": {"plate_height_m": 0.08}},
        {"conductor": Conductor(conductivity_s_per_m=5.8e7)},
    ],
)
def test_everything_that_changes_the_solution_changes_the_key(tmp_path, calls, change):
    ask(tmp_path)
    ask(tmp_path, **change)
    assert len(calls) == 2


def test_the_conductor_of_any_metal_changes_the_key():
    part = ("arm", *strip((0, 0, 0), (0, 0, 0.03), width_m=0.002, across=(0, 1, 0), rows=6))
    mesh = ported_mesh([part], [("ground", "arm")], frequency_hz=F, ground=True)
    copper = Conductor(conductivity_s_per_m=5.8e7)
    metals = (None, copper, replace(copper, roughness_factor=2.0))
    made = [replace(mesh, conductor=metal) for metal in metals]
    made.append(replace(made[1], wire_radius_m=np.full(len(mesh.faces), 0.0005)))
    assert len({response_cache._mesh_hash(one) for one in made}) == 4


def test_another_solver_does_not_read_old_files(tmp_path, calls, monkeypatch):
    ask(tmp_path)
    monkeypatch.setattr(response_cache, "_solver_hash", lambda: "a later version")
    ask(tmp_path)
    assert len(calls) == 2


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "foreign"])
def test_a_damaged_file_is_computed_again(tmp_path, calls, damage):
    before = ask(tmp_path)[0]
    (path,) = tmp_path.iterdir()
    content = bytearray(path.read_bytes())
    if damage == "cut":
        content = content[: len(content) // 2]
    elif damage == "flipped":
        content[len(content) // 2] ^= 0xFF
    else:
        content = b"" if damage == "empty" else b"not a solution"
    path.write_bytes(bytes(content))
    after = ask(tmp_path)[0]
    assert len(calls) == 2
    np.testing.assert_array_equal(after.response.pattern, before.response.pattern)
    ask(tmp_path)
    assert len(calls) == 2


def test_a_folder_that_cannot_be_written_only_warns(tmp_path, calls):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    with pytest.warns(CacheWarning, match="OCTANT_CACHE_DIR"):
        answer = ask(blocked / "cache")[0]
    assert answer.response.antennas == 4
    assert len(calls) == 1
    assert blocked.read_text() == "in the way"


def test_parallel_runs_share_a_folder(tmp_path, calls):
    with concurrent.futures.ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: ask(tmp_path)[0], range(16)))
    assert 1 <= len(calls) <= 16
    assert [p.suffix for p in tmp_path.iterdir()] == [".npz"]
    for answer in answers:
        np.testing.assert_array_equal(answer.response.pattern, answers[0].response.pattern)


def test_a_failure_is_not_kept(tmp_path):
    with pytest.raises(GeometryError, match="touches"):
        cached_responses(
            body(antennas=8, antenna_radius_m=0.001, plate_height_m=0.08),
            make_antenna("dipole", F),
            (F,),
            folder=tmp_path,
            **COARSE,
        )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_a_hopping_plan_costs_a_handful_of_solutions_and_keeps_all(tmp_path, monkeypatch):
    frequencies = tuple(np.linspace(2.40e9, 2.48e9, 6))
    bands = []
    solve_band = response_cache.solve_band

    def counted(*arguments, **named):
        bands.append(named["nodes"])
        return solve_band(*arguments, **named)

    monkeypatch.setattr(response_cache, "solve_band", counted)
    first = ask(tmp_path, frequencies)
    again = ask(tmp_path, frequencies[::-1])[::-1]
    assert bands == [4]
    assert [s.response.frequency_hz for s in first] == list(frequencies)
    for one, other in zip(first, again, strict=True):
        np.testing.assert_array_equal(one.response.pattern, other.response.pattern)
    # the same mesh solved at a frequency between the nodes
    mesh = response_cache.reader_mesh(
        body(),
        frequency_hz=frequencies[-1],
        length_m=make_antenna("dipole", F).length_m,
        **COARSE,
    )
    direct = solve_reader(mesh, frequency_hz=frequencies[2])
    np.testing.assert_allclose(first[2].ports.s_matrix, direct.s_matrix, atol=1e-3)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="the folder of Linux")
def test_the_folder_is_the_users_choice_or_the_platforms(monkeypatch, tmp_path):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "mine"))
    assert cache_folder() == tmp_path / "mine"
    monkeypatch.delenv(CACHE_VARIABLE)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "octant"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_folder() == tmp_path / ".cache" / "octant"


def test_no_warning_without_need(tmp_path, calls):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ask(tmp_path / "new" / "folder")
    assert len(calls) == 1


def test_metal_near_the_reader_is_another_reader(tmp_path, calls):
    near, far = (
        box((0.1, 0.1, 0.1), material="pec", position_m=(-0.05, -0.05, z)) for z in (-0.2, -0.3)
    )
    ask(tmp_path)
    ask(tmp_path, surroundings=(near,))
    ask(tmp_path, surroundings=(far,))
    assert len(calls) == 3
    assert calls[1][1]["surroundings"] == (near,)
    ask(tmp_path, surroundings=(near,))
    assert len(calls) == 3
