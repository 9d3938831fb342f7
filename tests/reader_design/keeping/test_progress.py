"""Progress is on stderr, tells the time left, and can be silent."""

import gc
import io
import time

import pytest

from octant.reader_design.keeping import progress as progress_module
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


class Terminal(io.StringIO):
    """What a terminal would get."""

    def isatty(self):
        return True


@pytest.mark.parametrize("expected_s", [None, 2.0])
def test_a_bar_is_drawn_while_nothing_is_counted(monkeypatch, expected_s):
    monkeypatch.setattr(progress_module, "TICK_S", 0.05)
    monkeypatch.setattr(progress_module, "FIRST_SHOWN_S", 0.1)
    shown = Terminal()
    progress = Progress(quiet=False, stream=shown)
    with progress.during("solving", expected_s=expected_s):
        time.sleep(0.5)
    drawn = shown.getvalue()
    assert drawn.count("solving: ") >= 4
    assert ("of about 2 s" in drawn) == (expected_s is not None)
    with progress.count(2, label="runs") as done:
        before = len(shown.getvalue())
        time.sleep(0.3)
        assert len(shown.getvalue()) > before
        done(2)
    assert "2/2" in shown.getvalue()


def test_what_ends_at_once_is_not_shown():
    shown = Terminal()
    with Progress(quiet=False, stream=shown).during("solving", expected_s=1.0):
        pass
    assert "solving" not in shown.getvalue()
