"""The entry point of the command line: parses the arguments, runs the command, reports errors.

Only the given command is imported, so that it starts fast. Exit codes: 0 success, 1 failure, 2 wrong command line, 130
interrupted by Ctrl-C.
"""

import argparse
import gc
import importlib
import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import TextIOWrapper
from typing import TYPE_CHECKING, Final

from homebot.cli.arguments import HelpFormatter, add_server_options, add_verb, unused_option
from homebot.cli.parser import SHELLS, CommandParser, PrintCompletion
from homebot.errors import ConfigError, HomebotError, UsageError
from homebot.support.output import clean_output
from homebot.version import __version__

if TYPE_CHECKING:
    from homebot.feature import Verb

COMMANDS: Final = {
    "run": "run homebot: find the devices of a house and control them",
    "new": "create a folder with an app, or a package for devices or with a feature, with tests",
    "app": "list, load, unload and reload apps of a running homebot",
    "gateway": "list gateways, and restart one",
    "group": "list groups of devices, with their members",
    "config": "check the configuration",
    "devices": "list the devices in the house",
    "find": "find devices by type, capability, state, room or name",
    "do": "command devices, and print the outcomes",
    "show": "show everything known about a device",
    "doctor": "diagnose problems, even before the start: gateways, silent devices, weak batteries, crashes, files",
    "forget": "remove a device from the index",
    "merge": "join entries that are the same device",
    "split": "separate devices that were joined by mistake",
    "place": "state the room of a device",
    "alias": "give a device another name",
    "approve": "allow commands to a dangerous device, such as a lock",
    "pair": "pair homebot with a device by code or button",
    "trust": "trust a device again after a sensor contradicted it",
    "leases": "list the values that programs hold, and until when",
    "release": "end the leases of a device",
    "answer": "list the questions of programs, and answer one",
    "places": "list, export and import the rooms of the house",
    "import": "add a device from a W3C Thing Description",
    "watch": "print each change and each command as it happens",
    "top": "show rates, queues and losses of topics, and the slowest handlers, live",
    "why": "explain why a device is in its state",
    "why-not": "explain why a device is not in a state",
    "journal": "list commands and changes with their causes and outcomes",
    "tag": "tag devices with words; read and write NFC tags",
    "mcp": "serve an agent over the Model Context Protocol",
    "reload": "apply changes in the configuration of a running homebot",
    "token": "create a token for a program, with the rights that it needs; list tokens",
    "topic": "list topics, and print their messages",
    "service": "list and call services; install homebot as a systemd service",
    "action": "list actions",
    "interface": "show the fields of a type",
    "param": "list and print parameters of nodes",
    "node": "list nodes",
    "home": "choose which data are those of the home",
    "backup": "write homebot's data and configuration to one file",
    "restore": "restore the data and configuration from a backup",
    "broker": "run only an MQTT broker",
}
"""The purpose of each command of the core in one line."""

_OWNER: Final = ("alias", "approve", "forget", "merge", "pair", "place", "split", "trust")
_MODULES: Final = {
    "import": "import_thing",
    "release": "leases",
    "reload": "app",
    "restore": "backup",
    "why-not": "why",
    **dict.fromkeys(_OWNER, "owner"),
}
"""The modules of commands with another name."""

_WRONG_COMMAND_LINE: Final = 2

_EPILOG = """\
examples:
  homebot run                                    try it in a simulated house
  homebot devices                                the devices in the house
  homebot find 'light and dimmable in kitchen'   the devices that match
  homebot do 'Kitchen lamp' on                   command a device, and see its outcome
  homebot why 'Kitchen lamp'                     why it is in its state
  homebot show 'Kitchen lamp'                    everything about one device
  homebot doctor                                 problems and their remedies
  homebot topic list -t                          every topic and its type
  homebot topic echo /rosout                     watch the log live
  homebot service call /rosapi/get_time          call a service
  homebot broker                                 only an MQTT broker

All commands except `run`, `replay`, `restore`, `broker`, `router`, `config`, `home`, `join`, `new` and `token`
connect to a running homebot, by default on 127.0.0.1:9090. See `homebot COMMAND --help` for their options.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line *argv* (by default the process's own) and return the exit code.

    Raises:
        SystemExit: The command line is wrong (code 2), or requests ``--help`` or ``--version`` (code 0).
    """
    argv = sys.argv[1:] if argv is None else argv
    if "run" in argv and hasattr(signal, "SIGHUP") and not has_terminal():  # Windows has no SIGHUP
        # It waits until ``serve`` can reload: so early, it would end the process, and it should at a terminal.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGHUP})
    for name in ("stdout", "stderr"):  # None if it was closed before the start
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(os.open(os.devnull, os.O_WRONLY), "w"))
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(
            errors="backslashreplace"
        )  # a device name may contain characters that a terminal cannot show
    with clean_output():
        return _run(argv)


def make_parser(argv: Sequence[str] | None = None) -> argparse.ArgumentParser:
    """Return the parser of *argv*, with the arguments of the command in it; by default, of all commands.

    If a command comes first, it knows no other, because creating all parsers takes 3 ms.
    """
    parser: argparse.ArgumentParser = CommandParser(
        prog="homebot",
        description="The home runtime for robots: find every device in the house, and control it.",
        epilog=_EPILOG,
        formatter_class=HelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"homebot {__version__}")
    parser.add_argument(
        "--print-completion",
        action=PrintCompletion,
        choices=SHELLS,
        whole_parser=make_parser,
        help='print the completion script for a shell; use it as: eval "$(homebot --print-completion bash)"',
    )
    add_server_options(parser)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    # For a known command, neither the list of all commands nor similar ones are needed.
    purposes = COMMANDS if argv and argv[0] in COMMANDS else all_commands()
    if argv and argv[0] not in purposes:
        _refuse_left_out(argv[0])
    for name in (argv[0],) if argv and argv[0] in purposes else purposes:
        command = add_verb(commands, name, purposes[name])
        if argv is None or name in argv:
            _add_arguments(name, command)
    return parser


def all_commands() -> dict[str, str]:
    """Return the purpose of each command, of the core and of features."""
    order, verbs = list(COMMANDS), _verbs()
    waiting = sorted(verbs, key=lambda name: verbs[name].after in verbs)  # last those that follow another of these
    for name in waiting:
        after = verbs[name].after
        order.insert(order.index(after) + 1 if after in order else len(order), name)
    return {name: verbs[name].purpose if name in verbs else COMMANDS[name] for name in order}


def _verbs() -> "dict[str, Verb]":
    from homebot.feature import all_features  # noqa: PLC0415 - the core's commands start without features

    return {name: verb for feature in all_features() for name, verb in feature.verbs.items()}


def _refuse_left_out(name: str) -> None:
    from homebot.feature import find_features  # noqa: PLC0415 - as above

    if problem := find_features().problems.get(name):
        raise UsageError(f"the feature {name} is left out: {problem}")


def has_terminal() -> bool:
    """Return whether the standard input is a terminal that is still there."""
    try:
        return os.isatty(0)
    except OSError:
        return False


def _run(argv: Sequence[str]) -> int:
    if argv[:1] == ["--complete-devices"]:
        from homebot.cli.device_completion import print_devices  # noqa: PLC0415 - asked by shells alone

        return print_devices(argv[1:])
    as_json = "--json" in argv
    try:
        options = make_parser(argv).parse_args(argv)
        as_json = getattr(options, "json", False)
        if problem := unused_option(options):
            _print_error(problem, as_json=as_json)
            return _WRONG_COMMAND_LINE
        command: Callable[[argparse.Namespace], int] = options.command
        code = command(options)
        sys.stdout.flush()
    except HomebotError as exc:
        from homebot.cli.owner_language import said  # noqa: PLC0415 - loads the table

        others = exc.others if isinstance(exc, ConfigError) else ()
        for error in (exc, *others):
            _print_error(said(str(error)), as_json=as_json)
        return 1
    except KeyboardInterrupt:
        return 130
    except OSError as exc:  # such as a full disk
        # Python would complain again when it flushes at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if isinstance(exc, BrokenPipeError):  # the reader of our output closed the pipe
            return 0
        _print_error(f"{exc.strerror or exc}{f': {exc.filename}' if exc.filename else ''}", as_json=as_json)
        return 1
    return code


def _print_error(text: str, *, as_json: bool) -> None:
    from homebot.cli.remarks import print_error  # noqa: PLC0415 - a start that goes well needs none

    print_error(text, as_json=as_json)


def _add_arguments(command: str, parser: argparse.ArgumentParser) -> None:
    with gc_paused(), _minimal_structlog_imports():
        if command not in COMMANDS:
            from homebot.feature import load  # noqa: PLC0415 - as above

            load(_verbs()[command].add_arguments)(parser)
            return
        module = importlib.import_module(f"homebot.cli.commands.{_MODULES.get(command, command)}")
    add_arguments: Callable[[argparse.ArgumentParser], None]
    add_arguments = getattr(module, f"add_{command.replace('-', '_')}_arguments", None) or module.add_arguments
    add_arguments(parser)


@contextmanager
def gc_paused() -> Iterator[None]:
    """Disable garbage collection during the block, and for modules loaded in it: saves a sixth of their import time."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


@contextmanager
def _minimal_structlog_imports() -> Iterator[None]:
    """Keep structlog from loading tracebacks and framework support, a tenth of a command's time."""
    unused = {"rich", "twisted"} - sys.modules.keys()
    for library in unused:
        sys.modules[library] = None  # type: ignore[assignment]  # Python's own way to say that there is none
    try:
        yield
    finally:
        for library in unused:
            del sys.modules[library]
