"""A moment of what ``tools/fuzz.py`` does by hand for hours, and that it sees what it looks for."""

import fuzz
import pytest

COUNTS = {"studies": 80, "csv": 3, "patterns": 15, "meshes": 20}
"""Trials of each kind in a default run."""


@pytest.mark.parametrize("kind", COUNTS)
def test_mutated_input_ends_as_it_should(kind):
    found = [(n, f.what) for n, _, f in fuzz.findings(kind, seed=1, count=COUNTS[kind])]
    assert not found


def test_a_trial_depends_on_its_seed_and_number_only():
    one, again, other = (fuzz.trial_of("studies", 7, number) for number in (3, 3, 4))
    assert one == again != other


@pytest.mark.parametrize(
    ("loading", "seen"),
    [
        (lambda _: 1 / 0, "ZeroDivisionError"),
        (lambda _: fuzz.np.log(fuzz.np.zeros(1)), "numpy: divide by zero at"),
    ],
)
def test_what_may_not_happen_is_found(monkeypatch, loading, seen):
    monkeypatch.setattr(fuzz, "load_study", loading)
    assert seen in fuzz.judged(fuzz.trial_of("studies", 1, 0)).what
