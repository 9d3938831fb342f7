import os

import pytest

from octant.em.blocks import cores, run_blocks


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="needs processor affinity")
def test_only_the_processors_of_the_affinity_count():
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(allowed)})
    try:
        assert cores() == 1
    finally:
        os.sched_setaffinity(0, allowed)
    assert cores() == len(allowed)


def test_every_row_is_done_once_and_progress_ends_at_all():
    done, calls = [], []
    run_blocks(
        lambda begin, end: done.extend(range(begin, end)),
        10,
        block_size=4,
        progress=lambda rows, of: calls.append((rows, of)),
    )
    assert sorted(done) == list(range(10))
    assert calls[-1] == (10, 10)
    assert len(calls) == 3
