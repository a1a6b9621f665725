"""The entry of the command line: reads the arguments, runs the command, turns errors into words and exit codes.

Nothing heavy is imported before a command is chosen, so ``--help`` and ``--version`` answer at once. Exit codes:
0 done, 1 it did not work, 2 the command line is wrong, 130 ended by Ctrl-C.
"""

from __future__ import annotations

import argparse
import gc
import importlib
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import TextIOWrapper

import homebot
from homebot.cli import broker, config, devices, doctor, find, forget, import_thing, node, run, service, show, topic
from homebot.cli.arguments import add_global_options
from homebot.cli.completion import SHELLS, PrintCompletion
from homebot.errors import HomebotError
from homebot.output import clean_output

__all__ = ["main", "make_parser", "uncollected"]

COMMANDS = (run, config, devices, find, show, doctor, forget, import_thing, topic, service, node, broker)

_EPILOG = """\
examples:
  homebot run                                  try it: embedded broker, simulated devices, light service
  homebot devices                              the devices in the house
  homebot find 'light and dimmable in kitchen'   the devices that match
  homebot show 'Kitchen lamp'                  everything about one device
  homebot doctor                               what is wrong
  homebot topic list -t                        every topic and its type
  homebot topic echo /rosout                   watch the log live
  homebot topic pub --once /hello std_msgs/String '{data: hi}'
  homebot service call /rosapi/get_time        call a service
  homebot broker                               an MQTT broker and nothing else

All commands but `run`, `broker` and `config` connect to a running homebot, by default on 127.0.0.1:9090. See
`homebot COMMAND --help` for the options of each.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line *argv* (by default the process's own) and return the exit code.

    Raises:
        SystemExit: The command line is wrong (code 2), or asked for ``--help`` or ``--version`` (code 0).
    """
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a device may be called what a terminal cannot show
    with clean_output():
        return _run(argv)


def _run(argv: Sequence[str] | None) -> int:
    options = make_parser().parse_args(argv)
    try:
        return _load(options.command)(options)
    except HomebotError as exc:
        print(f"homebot: {exc}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:
        # Whoever read our output has enough. Python would complain once more when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def make_parser() -> argparse.ArgumentParser:
    """Return the parser of the whole command line."""
    parser = argparse.ArgumentParser(
        prog="homebot",
        description="The home runtime for robots: find every device in the house, and act on it.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"homebot {homebot.__version__}")
    parser.add_argument(
        "--print-completion",
        action=PrintCompletion,
        choices=SHELLS,
        help='print the completion script for a shell; use it as: eval "$(homebot --print-completion bash)"',
    )
    add_global_options(parser)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in COMMANDS:
        command.add_parser(commands)
    return parser


def _load(command: str) -> Callable[[argparse.Namespace], int]:
    """Return the function that ``module:function`` names."""
    _import_structlog_without_rich()
    module, _, function = command.partition(":")
    with uncollected():
        found: Callable[[argparse.Namespace], int] = getattr(importlib.import_module(module), function)
    return found


@contextmanager
def uncollected() -> Iterator[None]:
    """Look for no garbage during the block: modules come to stay, and to look among them is a sixth of their time."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()


def _import_structlog_without_rich() -> None:
    """Keep structlog from loading rich, with which it would print tracebacks: 10 % of the time of a short command."""
    if "rich" in sys.modules or "structlog" in sys.modules:
        return
    sys.modules["rich"] = None  # type: ignore[assignment]  # Python's own way to say that there is none
    try:
        importlib.import_module("structlog")
    finally:
        del sys.modules["rich"]
