import os
from concurrent.futures import ThreadPoolExecutor
from threading import get_ident
from time import sleep

import pytest

from octant.em.blocks import THREADS_VARIABLE, cores, run_blocks


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


@pytest.mark.parametrize("threads", ["1", "2", "5"])
def test_an_error_in_any_block_is_raised_and_ends_the_work(monkeypatch, threads):
    monkeypatch.setenv(THREADS_VARIABLE, threads)
    begun = []

    def work(begin, _):
        begun.append(begin)
        if begin == 8:
            raise ValueError("block 8")
        sleep(1e-3)

    with pytest.raises(ValueError, match="block 8"):
        run_blocks(work, 100_000, block_size=4)
    assert len(begun) < 1_000


def test_an_executor_of_one_thread_does_all_blocks():
    done = []
    with ThreadPoolExecutor(1) as pool:
        run_blocks(
            lambda begin, _: done.append((begin, get_ident())), 9, block_size=4, executor=pool
        )
    assert sorted(begin for begin, _ in done) == [0, 4, 8]
    assert len({thread for _, thread in done} - {get_ident()}) == 1
