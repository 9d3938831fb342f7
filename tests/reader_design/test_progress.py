"""Progress is on stderr, tells the time left, and can be silent."""

import io

from octant.reader_design.progress import Progress, uncompiled_kernels


def test_quiet_progress_writes_nothing(capsys):
    progress = Progress()
    progress.say("hello")
    progress.announce_compilation(["em._path_kernels"])
    assert list(progress.track(range(3), label="cells")) == [0, 1, 2]
    assert capsys.readouterr() == ("", "")


def test_messages_and_bars_go_to_stderr_only(capsys):
    progress = Progress(quiet=False)
    progress.say("hello")
    list(progress.track(iter([1, 2]), total=2, label="cells"))
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


def test_kernels_without_an_index_beside_them_are_uncompiled(tmp_path):
    (tmp_path / "em" / "__pycache__").mkdir(parents=True)
    for name in ("_path_kernels.py", "_field_kernels.py", "paths.py"):
        (tmp_path / "em" / name).write_text("")
    assert uncompiled_kernels(tmp_path) == ("em._field_kernels", "em._path_kernels")
    (tmp_path / "em" / "__pycache__" / "_path_kernels.trace-12.py311.nbi").write_text("")
    assert uncompiled_kernels(tmp_path) == ("em._field_kernels",)
    (tmp_path / "em" / "fullwave").mkdir()
    (tmp_path / "em" / "fullwave" / "_rwg_kernels.py").write_text("")
    assert uncompiled_kernels(tmp_path) == ("em._field_kernels", "em.fullwave._rwg_kernels")


def test_only_needed_kernels_are_announced(capsys, monkeypatch):
    from octant.reader_design import progress as module

    monkeypatch.setattr(module, "uncompiled_kernels", lambda: ("em._a_kernels", "em._b_kernels"))
    Progress(quiet=False).announce_compilation(["em._b_kernels", "em._c_kernels"])
    error = capsys.readouterr().err
    assert "compiling em._b_kernels;" in error
    Progress(quiet=False).announce_compilation(["em._c_kernels"])
    assert capsys.readouterr().err == ""
