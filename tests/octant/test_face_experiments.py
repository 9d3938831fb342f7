"""What the methods of `octant.Study` leave is what the verbs leave, file by file, to the bit."""

import golden
import pytest

import octant


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "study", "call"),
    [
        ("optimise", "gap_and_shape.toml", lambda s, out: s.optimise(out, progress=False)),
        (
            "tolerance",
            "best_reader.toml",
            lambda s, out: s.tolerance(out, samples=3, progress=False),
        ),
        (
            "dock office",
            "docking_office.toml",
            lambda s, out: s.dock(out, runs=2, progress=False),
        ),
        ("track laboratory", "track_laboratory.toml", lambda s, out: s.track(out, progress=False)),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_method_of_study_leaves_what_its_verb_leaves(case, study, call, tmp_path):
    by_verb = golden.contents(golden.run_case(case, tmp_path / "verb"))
    folder = golden.examples_for(case, tmp_path / "face")
    result = call(octant.Study.load(folder / study), folder / "out")
    assert golden.contents(folder / "out") == by_verb
    assert "a report" in repr(result)


@pytest.mark.slow
def test_a_comparison_by_the_face_is_that_of_the_verb(tmp_path):
    by_verb = golden.contents(golden.run_case("compare", tmp_path / "verb"))
    folder = golden.examples_for("compare", tmp_path / "face")
    octant.Study.compare(folder / "layouts" / "short.toml", folder / "out", progress=False)
    assert golden.contents(folder / "out") == by_verb
