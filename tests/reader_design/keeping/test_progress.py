"""Progress is on stderr, tells the time left, and can be silent."""

import gc
import io

import pytest

from octant.reader_design.keeping.progress import Progress


def test_quiet_progress_writes_nothing(capsys):
    progress = Progress()
    progress.say("hello")
    with progress.track(range(3), label="cells") as tracked:
        assert list(tracked) == [0, 1, 2]
    assert capsys.readouterr() == ("", "")


def test_messages_and_bars_go_to_stderr_only(capsys):
    progress = Progress(quiet=False)
    progress.say("hello")
    with progress.track(iter([1, 2]), total=2, label="cells") as tracked:
        list(tracked)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "hello" in captured.err
    assert "cells: 100%" in captured.err
    assert "2/2" in captured.err


def test_a_count_shows_how_many_are_done(capsys):
    with Progress(quiet=False).count(4, label="runs") as done:
        done(1)
        done(4)
    assert "4/4" in capsys.readouterr().err
    with Progress().count(4, label="runs") as done:
        done(4)
    assert capsys.readouterr() == ("", "")


def test_a_stream_of_choice_takes_everything(capsys):
    stream = io.StringIO()
    Progress(quiet=False, stream=stream).say("hello")
    assert stream.getvalue() == "hello\n"
    assert capsys.readouterr() == ("", "")


def test_after_ctrl_c_a_bar_draws_nothing_below_the_last_message():
    # The error keeps the frame alive, and with it a bar that would end only when it is collected.
    stream = io.StringIO()

    def interrupted():
        with Progress(quiet=False, stream=stream).track(range(3), label="cells") as tracked:
            for _ in tracked:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as error:
        interrupted()
    stream.write("interrupted")
    del error
    gc.collect()
    assert "cells" in stream.getvalue()
    assert stream.getvalue().endswith("interrupted")
