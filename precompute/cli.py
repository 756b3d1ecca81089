# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: scans in, tables, numbers and pictures out.

Each subcommand is a module of ``precompute.commands``. With ``--json`` standard output holds one JSON object and
nothing else; progress goes to standard error, and so does the one sentence of an error, with exit code 2.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import re
import sys
import warnings
from collections.abc import Sequence
from typing import Any, NoReturn

from .commands import COMMANDS
from .errors import DiffractionError

#: Exit codes: the input's fault, and stopped by the user (128 + SIGINT).
EXIT_ERROR = 2
#: A check found what it looked for.
EXIT_FAULTS = 1
EXIT_INTERRUPTED = 130
#: Nobody reads on (128 + SIGPIPE), as for every program of a pipeline.
EXIT_PIPE = 141


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one sentence instead of printing the usage, and takes every negative number as one."""

    def __init__(self, **options: Any) -> None:
        super().__init__(allow_abbrev=False, **options)
        # argparse reads -1e-3 as an option otherwise.
        self._negative_number_matcher = re.compile(r"^-(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$")

    def error(self, message: str) -> NoReturn:
        self.exit(EXIT_ERROR, f"{one_sentence(message)} See '{self.prog} --help'.\n")


def one_sentence(message: object) -> str:
    """A message on one line, with a full stop, and a capital letter unless it starts with the name of a file."""
    text = " ".join(str(message).split()) or "Something went wrong"
    if text.split(maxsplit=1)[0].isalpha():
        text = text[0].upper() + text[1:]
    return text if text.endswith((".", "!", "?")) else text + "."


def build_parser(only: str | None = None) -> argparse.ArgumentParser:
    """The parser with all subcommands.

    Parameters
    ----------
    only
        Name of the one subcommand that gets its arguments; the others are not imported. None takes all.
    """
    parser = _Parser(prog="python -m precompute", description="Structural colours of measured nanostructured surfaces.")
    subparsers = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=_Parser)
    for name, summary in COMMANDS.items():
        sub = subparsers.add_parser(name, help=summary, description=summary)
        if only in (None, name):
            command = importlib.import_module(f".commands.{name}", __package__)
            command.add_arguments(sub)
            sub.add_argument("--json", action="store_true", help="print one JSON object on standard output")
            sub.set_defaults(run=command.run, describe=getattr(command, "describe", None))
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    arguments
        Without the program's name; None takes ``sys.argv``.

    Returns
    -------
    int
        The exit code: 0, 1 (a check found faults), 2 (one sentence on standard error says why) or 130 (interrupted).
    """
    words = sys.argv[1:] if arguments is None else list(arguments)
    # What the first word without a dash names; where it names nothing, the parser says so.
    command = next((word for word in words if not word.startswith("-")), "")
    try:
        args = build_parser(command).parse_args(words)
    except SystemExit as exit_:
        return int(exit_.code or 0)
    try:
        with warnings.catch_warnings():
            if not sys.warnoptions:
                # Standard error is for progress and the one sentence; libraries warn about their own affairs.
                warnings.simplefilter("ignore")
            result = args.run(args)
    except KeyboardInterrupt as error:
        print(str(error) or "Interrupted; nothing was written.", file=sys.stderr)
        return EXIT_INTERRUPTED
    except DiffractionError as error:
        print(one_sentence(error), file=sys.stderr)
        return EXIT_ERROR
    except MemoryError:
        print("Not enough memory; use a smaller scan, a smaller sigma_s or a coarser table.", file=sys.stderr)
        return EXIT_ERROR
    notes = "".join(one_sentence(f"Note: {note}") + "\n" for note in result.get("notes", ()))
    if args.json:
        text = json.dumps(result, allow_nan=False)
    else:
        shown = {key: value for key, value in result.items() if key != "notes"}
        text = args.describe(shown) if args.describe else describe(shown)
    return _print(text, notes) or (EXIT_FAULTS if result.get("faults") else 0)


def _print(text: str, notes: str) -> int:
    """The result, notes on standard error; quietly over where the reader has left (``info FILE | head``)."""
    stream = sys.stderr
    try:
        stream.write(notes)
        stream.flush()
        stream = sys.stdout
        print(text, flush=True)
    except BrokenPipeError:
        # Python flushes the stream once more as it ends; what is left goes nowhere.
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
        return EXIT_PIPE
    return 0


def describe(result: dict[str, Any]) -> str:
    """A readable summary: one line an entry."""
    width = max((len(key) for key in result), default=0)
    return "\n".join(f"{key:<{width}}  {_readable(value)}" for key, value in result.items())


def _readable(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_readable(item)}" for key, item in value.items())
    if isinstance(value, list | tuple):
        return "  ".join(_readable(item) for item in value)
    if isinstance(value, float):
        return f"{value:.6g}"
    return "-" if value is None else str(value)
