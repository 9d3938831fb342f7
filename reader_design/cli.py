"""The command line: verbs are loaded when they are called, so that ``octant --help`` is quick.

Data goes to stdout, everything else to stderr. Exit codes: 0 done, 2 bad input, 3 finished with
failed cells, 130 interrupted.
"""

import errno
import importlib
import os
import re
import sys
import warnings
from collections.abc import Sequence
from typing import Any, TextIO

import click
from click.shell_completion import CompletionItem

from octant.geometries.errors import CacheWarning, OctantError, PhysicsWarning
from octant.geometries.names import nearest_name
from octant.reader_design.compilation import HOW_TO_GIVE_A_PLACE, NO_PLACE_FOR_KERNELS
from octant.reader_design.terminal.colour import Kind, painted

VERBS = {
    "demo": ("commands.demo:demo", "The whole chain within a minute: room, map, drive, report."),
    "init": ("commands.init:init", "A first study of your room, from its mesh file."),
    "study": (
        "experiments.study.verb:study",
        "The main job: sweep, choice, map, missions, report.",
    ),
    "sweep": (
        "experiments.sweep.verb:sweep",
        "Any parameters swept: one resumable table of scores.",
    ),
    "map": ("commands.map:radio_map", "Received power over the floor of a room."),
    "paths": ("commands.paths:paths", "Every path between a transmitter and receivers."),
    "explain": ("commands.explain:explain", "One path's budget in dB, interaction by interaction."),
    "scene": (
        "commands.scene:scene",
        "The room as a GLB file and as a picture, with paths drawn.",
    ),
    "rss": ("commands.rss:rss", "What each antenna of the reader receives, pose by pose."),
    "reader": (
        "commands.reader:reader",
        "The reader by itself: impedances, S-matrix, patterns.",
    ),
    "optimise": (
        "experiments.optimise.verb:optimise",
        "Search for a reader design that reaches your goals.",
    ),
    "navigate": (
        "experiments.missions.verb:navigate",
        "Drive the robot through the tags of a study.",
    ),
    "compare": (
        "experiments.measured.compare_verb:compare",
        "A measured log beside what the study predicts.",
    ),
    "calibrate": (
        "experiments.measured.calibrate_verb:calibrate",
        "Fit materials, levels, places and tilts to a measured log.",
    ),
    "tolerance": (
        "experiments.tolerance.verb:tolerance",
        "What build errors do to the reader: yield, sensitivity, confidence.",
    ),
    "track": (
        "experiments.tracking.verb:track",
        "Follow a trajectory in a room from the RSS of tags.",
    ),
    "dock": (
        "experiments.docking.verb:dock",
        "Dock a robot at a tagged station, from across the room.",
    ),
    "simulate-log": (
        "experiments.measured.simulate_verb:simulate_log",
        "The log of readings that a drive through the room would bring home.",
    ),
    "replay": (
        "experiments.measured.replay_verb:replay",
        "A recorded drive through the navigators' estimators, against the truth.",
    ),
    "audit": ("commands.tables:audit", "What is wrong with a mesh, and what it means for rays."),
    "warm-up": (
        "commands.warm_up:warm_up",
        "Compile everything now, so that no command waits for it.",
    ),
    "materials": ("commands.tables:materials", "The table of materials."),
    "completion": (
        "commands.completion:completion",
        "What lets the shell complete verbs, options, tags, materials, files.",
    ),
}
CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 100}


STUDY_TEXT = (
    "STUDY is a study file (TOML), or the name of a built-in study: office, thesis, track or dock "
    "(a file of such a name is meant by ./NAME). Without it: {}."
)


class InterruptedRunError(Exception):
    """A run that Ctrl-C ended; its text says what is kept."""


class VerbGroup(click.Group):
    """The ``octant`` command, which imports the module of a verb when that verb is called."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the verbs in the order of the help page.

        Parameters
        ----------
        ctx : Of the call.
        """
        del ctx
        return list(VERBS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a verb, imported now; refuse an unknown one (exit code 2) with the nearest name.

        Parameters
        ----------
        ctx : Of the call.
        cmd_name : What was typed.
        """
        if cmd_name.startswith("-"):
            return None
        if cmd_name not in VERBS:
            if ctx.resilient_parsing:  # the shell completes what is not a verb yet
                return None
            near = nearest_name(cmd_name, VERBS, least_likeness=0.5)
            hint = f"did you mean {near!r}?" if near else f"the verbs are {', '.join(VERBS)}."
            msg = f"there is no verb {cmd_name!r}; {hint}"
            raise click.UsageError(msg, ctx=ctx)
        module, name = VERBS[cmd_name][0].split(":")
        command = getattr(importlib.import_module(f"{__package__}.{module}"), name)
        assert isinstance(command, click.Command)  # noqa: S101  the table above names commands only
        if any(parameter.name == "study" for parameter in command.params):
            command.epilog = STUDY_TEXT.format(
                cmd_name if cmd_name in {"track", "dock"} else "office"
            )
        return command

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Return the verbs that begin so, without importing them, or the options.

        Parameters
        ----------
        ctx, incomplete : Of the call; what is typed so far.
        """
        if incomplete.startswith("-"):
            return super().shell_complete(ctx, incomplete)
        return [
            CompletionItem(name, help=text)
            for name, (_, text) in VERBS.items()
            if name.startswith(incomplete)
        ]

    def invoke(self, ctx: click.Context) -> int | None:
        """Return the exit code; when the program that reads stdout has ended, that is no error.

        Parameters
        ----------
        ctx : Of the call.
        """
        try:
            result: int | None = super().invoke(ctx)
            sys.stdout.flush()
        except BrokenPipeError:
            # A pager or `head` has ended; without this, click would exit with 1 and
            # Python would complain once more when it flushes stdout at the end.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        return result

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of verbs without importing them.

        Parameters
        ----------
        ctx, formatter : Of the call, and where the help page is built.
        """
        del ctx
        with formatter.section("Verbs"):
            formatter.write_dl([(name, text) for name, (_, text) in VERBS.items()])


def _version(ctx: click.Context, _parameter: click.Parameter, wanted: bool) -> None:
    if wanted and not ctx.resilient_parsing:
        from importlib import metadata

        try:
            click.echo(f"octant {metadata.version('octant')}")
        except metadata.PackageNotFoundError:
            click.echo("octant (not installed: run from its working tree)")
        ctx.exit()


@click.group(
    cls=VerbGroup,
    context_settings=CONTEXT,
    invoke_without_command=True,
    epilog="Exit codes: 0 done, 2 bad input, 3 finished with failed cells, 130 interrupted. "
    "See 'octant VERB --help'. 'octant completion --help' says how the shell completes verbs, "
    "options, tags, materials and files.",
)
@click.option(
    "--version",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_version,
    help="Show the version and leave.",
)
@click.pass_context
def octant(ctx: click.Context) -> None:
    """Design bearing-sensitive RFID readers, and drive robots with them."""
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def run(arguments: Sequence[str] | None = None) -> int:
    """Return the exit code of one call of the command line; messages go to stderr.

    Parameters
    ----------
    arguments : What follows ``octant``; None: the process's own arguments.
    """
    with warnings.catch_warnings():
        warnings.showwarning = _warning_printer(set())
        warnings.simplefilter("always", PhysicsWarning)
        try:
            code = octant.main(
                args=None if arguments is None else list(arguments),
                prog_name="octant",
                standalone_mode=False,
            )
        except _EXPECTED as exc:
            line, code = _ending(exc)
            _say(" ".join(line.split()), "error")
        except RuntimeError as exc:
            if not str(exc).startswith(NO_PLACE_FOR_KERNELS):
                raise
            _say(f"error: {HOW_TO_GIVE_A_PLACE}", "error")
            code = 2
    return code if isinstance(code, int) else 0


def main() -> None:
    """Run the command line and end the process with its exit code."""
    sys.exit(run())


_EXPECTED = (
    click.ClickException,
    click.Abort,
    OctantError,
    InterruptedRunError,
    KeyboardInterrupt,
    MemoryError,
    OSError,
)
NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS)
"""Where nothing more can be written: the disk or one's share of it is full, or it is read-only."""


def _ending(exc: BaseException) -> tuple[str, int]:
    if isinstance(exc, InterruptedRunError):
        return f"interrupted: {exc}", 130
    if isinstance(exc, click.Abort | KeyboardInterrupt):
        return "interrupted: nothing was written.", 130
    if isinstance(exc, click.ClickException):
        return f"error: {_shortened(exc.format_message())}", 2
    if isinstance(exc, MemoryError):
        return f"error: {_memory_text(exc)}", 2
    if isinstance(exc, OSError) and not isinstance(exc, OctantError):
        what = f"error: {_shortened(str(exc.filename or 'a file'))}: {exc.strerror or exc}"
        if exc.errno in NO_ROOM:
            what += "; make room there or give another place, and repeat the command"
        return f"{what}.", 2
    return f"error: {_shortened(str(exc))}", 2


def _shortened(message: str) -> str:
    """Return a message in which a word of what was given is at most so long."""
    return re.sub(r"\S{300,}", lambda found: f"{found[0][:100]}…{found[0][-100:]}", message)


def _memory_text(exc: MemoryError) -> str:
    from octant.em.blocks import free_memory_bytes

    asked = re.search(r"[\d.]+ [KMGTPE]iB", str(exc))
    more = f"{asked[0]} more than there is" if asked else "more memory than there is"
    return (
        f"this needs {more} ({free_memory_bytes() / 1e9:.2g} GB are free); what takes memory is a "
        "reader or a room that is large in wavelengths, diffraction and many reflections among "
        "many faces, a fine map, and many long runs: ask for less of these."
    )


def _say(line: str, kind: Kind) -> None:
    """Write a line to stderr, its first word in colour where the terminal takes it."""
    word, _, rest = line.partition(" ")
    sys.stderr.write(f"{painted(word, kind, sys.stderr)} {rest}\n")


def _warning_printer(seen: set[str]) -> Any:  # noqa: ANN401  the signature is Python's own
    def show(  # noqa: PLR0917
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        del filename, lineno, file, line
        if not issubclass(category, PhysicsWarning | CacheWarning):
            return  # what another library warns of is nothing that a user can change
        text = " ".join(str(message).split())
        if text not in seen:
            seen.add(text)
            _say(f"warning: {text}", "warning")

    return show
