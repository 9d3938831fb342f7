"""What is written resolved reads back to the same study."""

from pathlib import Path

import msgspec
from hypothesis import given
from hypothesis import strategies as st

from octant.reader_design.study_file.loading import load_study, parse_study, to_toml
from octant.reader_design.study_file.schema import Study

lengths = st.floats(min_value=1e-3, max_value=1e3)
points = st.tuples(*[st.floats(min_value=-1e6, max_value=1e6)] * 3)
names = st.text(
    st.characters(exclude_categories=("Cs", "Cc"), exclude_characters="/\\"),
    min_size=1,
    max_size=12,
).filter(str.strip)
materials = st.one_of(
    st.sampled_from(["concrete", "metal", "pec"]),
    st.builds(lambda t: {"name": "concrete", "thickness_m": t}, lengths),
    st.builds(lambda e, s: {"eps_r": 1.0 + e, "sigma_s_per_m": s}, lengths, lengths),
    st.builds(
        lambda t, e: {
            "layers": [{"material": "wood", "thickness_m": t}, {"name": "air", "thickness_m": e}]
        },
        lengths,
        lengths,
    ),
)
objects = st.one_of(
    st.fixed_dictionaries(
        {
            "kind": st.sampled_from(["cabinet", "box"]),
            "size_m": st.tuples(lengths, lengths, lengths),
            "position_m": points,
            "material": materials,
        },
        optional={"yaw_deg": st.floats(-720.0, 720.0), "name": names},
    ),
    st.fixed_dictionaries(
        {
            "kind": st.just("cylinder"),
            "radius_m": lengths,
            "height_m": lengths,
            "position_m": points,
            "material": materials,
        }
    ),
    st.fixed_dictionaries(
        {
            "kind": st.just("sphere"),
            "radius_m": lengths,
            "position_m": points,
            "material": materials,
        }
    ),
)
surfaces = st.fixed_dictionaries({"walls": materials, "floor": materials, "ceiling": materials})
rooms = st.one_of(
    st.fixed_dictionaries(
        {
            "box_m": st.tuples(lengths, lengths, lengths),
            "origin_m": points,
            "material": st.one_of(materials, surfaces),
            "object": st.lists(objects, max_size=2),
        }
    ),
    st.fixed_dictionaries({"free_space": st.just(True), "object": st.lists(objects, max_size=2)}),
    st.just({"outline_m": [[0, 0], [4, 0], [4, 1], [1, 1], [1, 4], [0, 4]], "height_m": 2.5}),
)
studies = st.fixed_dictionaries(
    {"name": names, "seed": st.integers(0, 2**62), "room": rooms},
    optional={
        "tag": st.lists(
            st.fixed_dictionaries({"id": names, "position_m": points}),
            max_size=3,
            unique_by=lambda tag: tag["id"],
        ),
        "layout": st.lists(
            st.fixed_dictionaries(
                {"name": names}, optional={"room": rooms, "object": st.lists(objects, max_size=2)}
            ),
            max_size=2,
            unique_by=lambda layout: layout["name"],
        ),
        "sweep": st.fixed_dictionaries({"plate_height_m": st.just([0.0, 0.08])}),
        "map": st.fixed_dictionaries({"spacing_m": lengths}),
    },
)


@given(studies)
def test_resolved_toml_reads_back_to_an_equal_study(tables):
    from octant.reader_design.study_file.checks import check_study
    from octant.reader_design.study_file.loading import resolved

    study = msgspec.convert(tables, Study)
    check_study(study)
    study = resolved(study, directory=Path.cwd())
    again = parse_study(to_toml(study), source="again", directory=Path("/"))
    assert again == study
    assert to_toml(again) == to_toml(study)


def test_built_in_study_reads_back():
    study = load_study("thesis")
    assert parse_study(to_toml(study), source="again", directory=Path("/")) == study


def test_every_default_is_written_out():
    text = to_toml(parse_study('name="x"\n[room]\nbox_m=[5,5,3]\n', source="s", directory=Path()))
    for line in (
        "seed = 1",
        "tag_power_w = 1.0",
        "max_reflections = 3",
        'response = "fullwave"',
        "wire_radius_m = 0.0005",
        "feed_gap_m = 0.0057",
        "cells_per_wavelength = 10.0",
    ):
        assert line in text.splitlines()
