"""One call of the command line, in this process, with what it wrote."""

from dataclasses import dataclass

import pytest

from octant.reader_design.cli import run


@dataclass(frozen=True)
class Call:
    code: int
    out: str
    err: str

    @property
    def problems(self):
        """Lines on stderr that are neither warnings nor news of kernels being compiled."""
        other = ("warning: ", "First use on this machine: ")
        return [line for line in self.err.splitlines() if not line.startswith(other)]

    def refused(self):
        """The one sentence of a refusal: exit code 2, one line, no traceback."""
        assert self.code == 2, self
        assert "Traceback" not in self.err
        assert len(self.problems) == 1, self.err
        assert self.problems[0].startswith("error: ")
        return self.problems[0]


@pytest.fixture
def octant(capsys):
    def call(*arguments):
        capsys.readouterr()
        code = run([str(a) for a in arguments])
        return Call(code, *capsys.readouterr())

    return call


ROOM = """
name = "box"
[room]
box_m = [5.0, 5.0, 3.0]
material = "concrete"
"""


@pytest.fixture
def study_file(tmp_path):
    def write(text=ROOM, name="study.toml"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return write
