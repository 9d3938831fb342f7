"""Short runs of every verb give the numbers that are kept in golden.json."""

import json
import math

import golden
import pytest

KEPT = json.loads(golden.GOLDEN.read_text())
CLOSED_LOOP = ("study", "navigate", "compare", "dock", "track")
"""Verbs that drive robots: each step repeats the rounding of the last and makes it larger."""


@pytest.mark.slow
@pytest.mark.parametrize("name", golden.CASES)
def test_numbers_are_those_that_were_kept(name, tmp_path):
    found = golden.contents(golden.run_case(name, tmp_path))
    kept = KEPT["cases"][name]
    assert {f: sorted(v) for f, v in found.items()} == {f: sorted(v) for f, v in kept.items()}
    here = golden.machine() == KEPT["machine"]
    if not here and name.startswith(CLOSED_LOOP):
        return  # another processor or library rounds differently, and a robot's path with it
    wrong = [
        f"{file}: {variable}: {kept[file][variable]} became {new}"
        for file, variables in found.items()
        for variable, new in variables.items()
        if not (new == kept[file][variable] if here else _near(new, kept[file][variable]))
    ]
    assert not wrong, "\n".join(wrong)


def _near(new, old):
    """Whether shape and values agree as far as another machine's rounding allows."""
    if new["shape"] != old["shape"]:
        return False
    pairs = zip(new.get("values", ()), old.get("values", ()), strict=True)
    return all(
        a == b if isinstance(a, str) or isinstance(b, str) else math.isclose(a, b, rel_tol=1e-6)
        for a, b in pairs
    )
