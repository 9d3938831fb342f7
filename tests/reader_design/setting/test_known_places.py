"""Where the robot's places are known, the search leaves out what reaches none, and power stays."""

import math

import numpy as np
import pytest

from octant.em.search import images
from octant.geometries.errors import GeometryError
from octant.reader_design.face.rss_map import MapView, spread_map, tag_map
from octant.reader_design.setting.setting import build_setting
from octant.reader_design.study_file.loading import load_study

STUDY = """
[room]
box_m = [4.0, 3.0, 2.5]
[[room.object]]
kind = "cabinet"
size_m = [0.4, 2.0, 2.0]
position_m = [1.8, 0.0, 0.0]
[[room.object]]
kind = "box"
material = "wood"
size_m = [0.8, 0.8, 0.7]
position_m = [3.0, 0.5, 0.0]
[[room.object]]
kind = "cylinder"
material = "metal"
radius_m = 0.3
height_m = 1.5
position_m = [3.2, 2.3, 0.0]
[radio]
frequency_hz = 2.4e9
[[tag]]
id = "a"
position_m = [0.7, 1.0, 2.2]
[[tag]]
id = "b"
kind = "passive"
position_m = [0.8, 1.6, 2.2]
[rfid]
power_w = 1.0
[reader]
response = "isolated"
[solver]
max_reflections = 2
"""
AXES = (np.arange(0.1, 1.7, 0.2), np.arange(0.1, 3.0, 0.2))
PLACES = np.stack(np.meshgrid(*AXES, indexing="ij"), axis=-1).reshape(-1, 2)


@pytest.fixture
def setting(monkeypatch, tmp_path):
    """A room in which every scene counts as one of very many facets."""
    monkeypatch.setattr(images, "DENSE_FACETS", -1)
    (tmp_path / "study.toml").write_text(STUDY)
    return build_setting(load_study(tmp_path / "study.toml"))


@pytest.mark.parametrize("tag_id", ["a", "b"])
def test_links_for_known_places_have_fewer_images_and_the_same_power(setting, tag_id):
    tag = setting.tag(tag_id)
    poses = np.column_stack((PLACES, np.full(len(PLACES), 0.3)))
    anywhere, known = setting.link(tag), setting.link(tag, places_m=PLACES)
    one, other = anywhere.power(poses), known.power(poses)
    assert other.coherent_w == pytest.approx(one.coherent_w, rel=1e-9)
    assert np.array_equal(one.path_count, other.path_count)
    way, other = ((link.ways[0] if tag_id == "b" else link) for link in (anywhere, known))
    assert other.bands[0].tree.kept[-1] < 0.9 * way.bands[0].tree.kept[-1]
    with pytest.raises(GeometryError, match="is none of the"):
        known.power([(3.5, 1.5, 0.0)])


def test_maps_ask_for_their_own_places_only(setting, monkeypatch):
    tag = setting.tag("a")
    kept = []
    whole = images.search_images

    def counted(*given, **more):
        tree = whole(*given, **more)
        kept.append((int(tree.kept[-1]), int(whole(*given).kept[-1])))
        return tree

    monkeypatch.setattr("octant.em.search.candidates.search_images", counted)
    found = {}
    for dense in (True, False):
        monkeypatch.setattr(images, "DENSE_FACETS", -1 if dense else 10_000)
        for isotropic in (True, False):
            view = MapView(axes=AXES, heading_rad=0.5 * math.pi, isotropic=isotropic)
            found[dense, isotropic] = tag_map(setting, tag, view, progress=lambda _: None)
        found[dense, "spread"] = spread_map(setting, tag, view, progress=lambda _: None)
    assert len(kept) == 6
    assert all(few < 0.9 * all_of_them for few, all_of_them in kept[:3])
    for isotropic in (True, False):
        one, other = found[True, isotropic], found[False, isotropic]
        assert one.coherent_w == pytest.approx(other.coherent_w, rel=1e-9)
        assert np.array_equal(one.path_count, other.path_count)
    delays = [found[dense, "spread"].delay_spread_s for dense in (True, False)]
    assert delays[0] == pytest.approx(delays[1], rel=1e-9, nan_ok=True)
