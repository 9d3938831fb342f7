"""``octant completion``: the script with which a shell completes the command line."""

import os
from pathlib import Path
from typing import Literal

import click
from click.shell_completion import get_completion_class

from octant.reader_design.cli import octant

SHELLS = ("bash", "zsh", "fish")
VARIABLE = "_OCTANT_COMPLETE"
"""How the script asks the program for completions; click fixes the name."""


@click.command(
    epilog="""\b
bash  add to ~/.bashrc:  eval "$(octant completion bash)"
zsh   add to ~/.zshrc:   eval "$(octant completion zsh)"
fish  once:  octant completion fish > ~/.config/fish/completions/octant.fish
"""
)
@click.argument("shell", type=click.Choice(SHELLS), required=False)
def completion(shell: Literal["bash", "zsh", "fish"] | None) -> None:
    """Print the script that lets SHELL complete verbs, options, tags, materials, files.

    Without SHELL: the one that the variable SHELL names, or bash. Tags are those of the study on
    the line.
    """
    named = Path(os.environ.get("SHELL", "")).name
    shell = shell or (named if named in SHELLS else "bash")  # type: ignore[assignment]
    kind = get_completion_class(str(shell))
    assert kind is not None  # noqa: S101  click knows all three
    click.echo(kind(octant, {}, "octant", VARIABLE).source())
