"""Colour where a terminal takes it: never in a pipe, never against NO_COLOR."""

import os
from typing import Literal, TextIO

import click

Kind = Literal["good", "fair", "poor", "warning", "error"]

COLOURS: dict[Kind, str] = {
    "good": "green",
    "fair": "yellow",
    "poor": "red",
    "warning": "yellow",
    "error": "red",
}


def takes_colour(stream: TextIO) -> bool:
    """Return whether text written to a stream may hold colour.

    ``NO_COLOR`` (set to anything) forbids it, ``FORCE_COLOR`` asks for it in a pipe too.

    Parameters
    ----------
    stream : Where the text goes.
    """
    if os.environ.get("NO_COLOR"):
        return False
    if os.environ.get("FORCE_COLOR"):
        return True
    return os.environ.get("TERM") != "dumb" and stream.isatty()


def painted(text: str, kind: Kind | None, stream: TextIO) -> str:
    """Return the text in the colour of its kind, where the stream takes colour.

    Parameters
    ----------
    text, kind, stream : What is written, as what (None: plain), and where it goes.
    """
    if kind is None or not takes_colour(stream):
        return text
    return click.style(text, fg=COLOURS[kind], bold=kind == "error")


def judged(share: float) -> Kind:
    """Return how good a share of successes is: from 0.9 on, from 0.5 on, below.

    Parameters
    ----------
    share : Of all runs [-].
    """
    return "good" if share >= 0.9 else "fair" if share >= 0.5 else "poor"
