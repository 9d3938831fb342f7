"""The drawing tells every length that a workshop needs, to scale, and is the same each time."""

import sys

import msgspec
import numpy as np
import pytest
from matplotlib.patches import Polygon

import octant
from octant.geometries.errors import ConfigError, GeometryError
from octant.reader_design.showing.dxf_files import write_dxf
from octant.reader_design.showing.workshop import drawing, drawing_scale, save_drawing
from octant.reader_design.study_file.reader import Reader
from octant.reader_design.study_file.reader_feed import ReaderFeed

READER = Reader(
    antenna_radius_m=0.0945,
    antenna_length_m=0.0535,
    plate_height_m=0.0672,
    plate_height_axis_m=0.0884,
    plate_outer_radius_m=0.0987,
    ground_plane_shape="round",
    gap_m=0.0041,
    load_ohm=180.0,
)


def words(figure):
    return " | ".join(text.get_text() for ax in figure.axes for text in ax.texts)


@pytest.mark.parametrize(
    "length", ["94.5", "53.5", "67.2", "88.4", "98.7", "gap 4.1", "Ø 200", "180 Ω", "5.7", "189"]
)
def test_every_length_is_on_the_sheet(length):
    figure = drawing(READER, frequency_hz=2.4e9, title="test")
    assert length in words(figure)


def test_views_are_to_scale():
    figure = drawing(READER, frequency_hz=2.4e9, title="test")
    assert "scale 1:2 on A4" in words(figure)
    for ax in figure.axes[:2]:
        box = ax.get_position()
        paper_mm = np.array([297.0 * box.width, 210.0 * box.height])
        shown_mm = np.array([np.ptp(ax.get_xlim()), np.ptp(ax.get_ylim())])
        np.testing.assert_allclose(shown_mm / paper_mm, 2.0, rtol=1e-9)


@pytest.mark.parametrize("shape", ["square", "octagon", "round"])
@pytest.mark.parametrize("antenna", ["dipole", "monopole"])
def test_any_design_can_be_drawn(shape, antenna):
    design = msgspec.structs.replace(READER, ground_plane_shape=shape, antenna=antenna, antennas=6)
    if shape == "octagon":
        design = msgspec.structs.replace(design, antennas=8)
    text = words(drawing(design, frequency_hz=2.4e9, title="any"))
    assert f"{design.antennas} {antenna}s" in text


def corners_of_planes(figure, side_mm):
    """The squares of the top view, (k, 4, 2) [mm]."""
    shapes = [p.get_xy()[:-1] for p in figure.axes[0].patches if isinstance(p, Polygon)]
    squares = [s for s in shapes if len(s) == 4]
    return np.array([s for s in squares if np.isclose(np.ptp(s, axis=0).min(), side_mm, rtol=0.5)])


@pytest.mark.parametrize("antennas", [6, 8])
def test_own_planes_of_monopoles_are_on_the_sheet(antennas):
    design = msgspec.structs.replace(
        READER, antenna="monopole", antennas=antennas, gap_m=0.0261, monopole_plane_m=0.03
    )
    figure = drawing(design, frequency_hz=2.4e9, title="monopoles")
    row = f"{antennas}, square, side 30, turned to the radius, 26.1 above the plane, not joined"
    assert row in words(figure)
    assert "own plane 30" in words(figure)
    planes = corners_of_planes(figure, 30.0)
    assert len(planes) == antennas
    for i, plane in enumerate(planes):
        at = 2.0 * np.pi * i / antennas
        middle = 94.5 * np.array((np.cos(at), np.sin(at)))
        np.testing.assert_allclose(plane.mean(axis=0), middle, atol=1e-9)
        along = (plane - middle) @ np.array((np.cos(at), np.sin(at)))
        np.testing.assert_allclose(np.abs(along), 15.0, atol=1e-9)  # two sides along the radius
        np.testing.assert_allclose(np.hypot(*(plane - middle).T), 15.0 * np.sqrt(2.0), atol=1e-9)


def test_monopoles_on_the_ground_plane_have_no_own_planes_on_the_sheet():
    design = msgspec.structs.replace(READER, antenna="monopole", monopole_plane_m=0.0)
    figure = drawing(design, frequency_hz=2.4e9, title="joined")
    assert "own plane" not in words(figure)
    assert "between the ground plane and the wire's foot" in words(figure)


def test_a_reader_without_plates_has_none_on_the_sheet():
    design = msgspec.structs.replace(READER, plate_height_m=0.0, plate_height_axis_m=None)
    assert "rim" not in words(drawing(design, frequency_hz=2.4e9, title="bare"))


def test_equal_drawings_give_equal_files(tmp_path):
    for kind in ("svg", "pdf"):
        for name in ("a", "b"):
            figure = drawing(READER, frequency_hz=2.4e9, title="test")
            save_drawing(figure, tmp_path / f"{name}.{kind}")
        first, second = (tmp_path / f"{n}.{kind}" for n in ("a", "b"))
        assert first.read_bytes() == second.read_bytes()


def test_a_design_that_cannot_be_built_is_refused():
    design = msgspec.structs.replace(READER, antenna_radius_m=0.2)
    with pytest.raises(GeometryError, match="antenna_radius_m"):
        drawing(design, frequency_hz=2.4e9, title="too wide")


@pytest.mark.parametrize("antenna", ["dipole", "monopole"])
def test_dxf_is_to_scale_and_its_dimensions_measure_what_they_say(antenna, tmp_path):
    ezdxf = pytest.importorskip("ezdxf")
    design = msgspec.structs.replace(READER, antenna=antenna)
    sheet = drawing(design, frequency_hz=2.4e9, title="test")
    for name in ("a.dxf", "b.dxf"):
        write_dxf(sheet, tmp_path / name, scale=drawing_scale(design))
    assert (tmp_path / "a.dxf").read_bytes() == (tmp_path / "b.dxf").read_bytes()
    document = ezdxf.readfile(tmp_path / "a.dxf")
    assert not document.audit().errors
    assert document.header["$INSUNITS"] == 4
    space = document.modelspace()
    measured = {d.dxf.text: d.get_measurement() for d in space.query("DIMENSION")}
    assert {"Ø 200", "88.4", "plate 98.7", "rim 67.2", "53.5", "r_a 94.5"} <= set(measured)
    for text, length in measured.items():
        assert float(text.split()[-1]) == pytest.approx(length, abs=0.051)
    circles = {round(c.dxf.radius, 6) for c in space.query("CIRCLE[layer=='OUTLINE']")}
    assert {100.0, 94.5} <= circles
    plates = [p for p in space.query("LWPOLYLINE[layer=='PLATES']") if len(p) == 2]
    ends = np.array([[v[:2] for v in p.get_points()] for p in plates])
    assert len(ends) == 8
    np.testing.assert_allclose(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), 98.7)


def test_dxf_without_its_package_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    with pytest.raises(ConfigError, match=r"octant\[cad\]"):
        octant.Reader().drawing(tmp_path / "a.dxf")


def test_a_reader_draws_itself_in_every_form(tmp_path):
    for name in ("a.svg", "a.dxf"):
        octant.Reader().drawing(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 1000
    with pytest.raises(ConfigError, match="ends in"):
        octant.Reader().drawing(tmp_path / "a.step")


def test_long_rows_of_the_parts_list_stay_in_their_column():
    each = tuple(f"{i}.9 nH across, {i}.5 pF in series, {i}.2 pF across" for i in range(1, 9))
    design = Reader(line=ReaderFeed(match=each))
    figure = drawing(design, frequency_hz=2.44e9, title="reader")
    figure.canvas.draw()
    ax = next(a for a in figure.axes if any(t.get_text() == "networks" for t in a.texts))
    to_mm = ax.transData.inverted()
    boxes = [to_mm.transform(text.get_window_extent()) for text in ax.texts]
    ends = [high[0] for low, high in boxes if 30.0 < low[0] < 216.0]
    assert len(ends) > 8
    assert max(ends) < 216.0
