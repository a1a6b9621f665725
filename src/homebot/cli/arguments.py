"""Shared parts of the commands' parsers: commands, common options, and argument types."""

import argparse
import math
import os
import re
from collections.abc import Callable, Collection
from ipaddress import ip_address
from pathlib import Path
from textwrap import fill
from typing import Final, NamedTuple, TypeAlias
from urllib.parse import urlsplit

from homebot.errors import ConfigError, UsageError

DEFAULT_CONFIG = Path("homebot.toml")
"""The configuration in the working directory, of `homebot run` and of client commands."""

DEFAULT_BROKER = "mqtt://localhost:1883"
DEFAULT_SERVER = ("127.0.0.1", 9090)


class ServerHost(NamedTuple):
    """The address of a rosbridge server."""

    host: str
    port: int
    has_tls: bool = False


Command: TypeAlias = "Callable[[argparse.Namespace], int]"
Commands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"  # noqa: SLF001 - argparse has no other way
"""The subcommands of a command."""

_CONNECTION: Final = ("door", "home", "token_file")
"""The options that select the homebot that a command connects to."""

_NEGATIVE: Final = re.compile(r"-\.?[0-9].*")
"""A value below zero, perhaps with a unit: ``-10%`` is no option."""

_HOST = re.compile(r"[\w.-]+")
_NUMBER = re.compile(r"-?[0-9]+([.][0-9]*)?")


class HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """Formatter that wraps paragraphs at the width of the terminal, and long examples before their explanations."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        del indent
        lines = re.sub(r"(?<=\S)\n(?=\S)", " ", text).splitlines()
        for place, line in enumerate(lines):
            if len(line) > width:
                lines[place] = re.sub(r"(?<=\S)  +", "\n      ", line) if line[0] == " " else fill(line, width)
        return "\n".join(lines)


def set_command(
    parser: argparse.ArgumentParser, command: Command, examples: str, global_options: Collection[str] = ()
) -> None:
    """Make *parser* run *command*, which returns the exit code and uses these *global_options*."""
    parser.epilog = f"examples:\n{examples}"
    parser._negative_number_matcher = _NEGATIVE  # noqa: SLF001 - argparse has no other way
    parser.set_defaults(command=command, command_name=parser.prog, used_options=frozenset(global_options))


def set_client_command(parser: argparse.ArgumentParser, command: Command, examples: str, *, acts: bool = False) -> None:
    """Make *parser* run *command*, which connects to a running homebot and, if it *acts*, changes something."""
    set_command(parser, command, examples, _CONNECTION)
    parser.set_defaults(acts=acts)
    add_server_options(parser, argparse.SUPPRESS)


def add_verbs(parser: argparse.ArgumentParser, examples: str) -> Commands:
    """Return the group of subcommands of *parser*, such as ``list`` of ``homebot topic``."""
    parser.epilog = f"examples:\n{examples}"
    return parser.add_subparsers(title="commands", metavar="COMMAND", required=True)


def add_verb(verbs: Commands, name: str, summary: str) -> argparse.ArgumentParser:
    """Add a subcommand to *verbs*."""
    return verbs.add_parser(
        name,
        help=summary,
        description=f"{summary[0].upper()}{summary[1:]}.",
        formatter_class=HelpFormatter,
    )


def unused_option(options: argparse.Namespace) -> str:
    """Return the problem if *options* contain a global option that the command does not use; empty otherwise."""
    for name in _CONNECTION:
        if getattr(options, name, None) is not None and name not in options.used_options:
            option, command = f"--{name.replace('_', '-')}", options.command_name
            where = "; the configuration file has the tokens of its clients" if "door" in options.used_options else ""
            return f"{option} is for commands that connect to a running homebot; `{command}` does not{where}"
    return ""


def add_broker_option(parser: argparse.ArgumentParser) -> None:
    """Add the option for the broker in Thing Descriptions."""
    parser.add_argument(
        "--broker",
        metavar="URL",
        type=broker_url,
        default=DEFAULT_BROKER,
        help=f"MQTT broker to name in Thing Descriptions (default: {DEFAULT_BROKER})",
    )


def add_log_format(parser: argparse.ArgumentParser) -> None:
    """Add ``--log-format`` of a command that serves."""
    parser.add_argument(
        "--log-format",
        choices=("console", "json"),
        default="console",
        help="log lines for people (console) or programs (json)",
    )


def add_time_limit(parser: argparse.ArgumentParser) -> None:
    """Add ``--for TIME`` as ``seconds``."""
    parser.add_argument(
        "--for", dest="seconds", metavar="TIME", type=seconds, help="stop after TIME: seconds, or a text such as 2m"
    )


def broker_url(text: str) -> str:
    """Return the address of a broker, without user and password, because descriptions are public."""
    try:
        split = urlsplit(text)
        is_broker = split.scheme in {"mqtt", "mqtts"} and bool(split.hostname) and split.port != 0
    except ValueError:
        is_broker = False
    if not is_broker or "@" in text:
        raise argparse.ArgumentTypeError(
            f"a broker is mqtt://HOST[:PORT] or mqtts://HOST[:PORT], got {_hidden(text)!r}"
        )
    return text.rstrip("/")


def address(text: str, example: int = 9090) -> tuple[str, int]:
    """Return the host and port of ``HOST:PORT``; an IPv6 address is in brackets.

    Args:
        example: The port in the error's example.

    Raises:
        argparse.ArgumentTypeError: It is not an address.
    """
    host, _, port = text.rpartition(":")
    is_port = port.isascii() and port.isdigit() and len(port) <= 5 and int(port) <= 65535
    bare = host[1:-1] if host.startswith("[") and host.endswith("]") else host
    if not is_port or not _is_host(bare):
        raise argparse.ArgumentTypeError(
            f"an address is HOST:PORT, such as 127.0.0.1:{example} or [::1]:{example}, got {_hidden(text)!r}"
        )
    return bare, int(port)


def server_address(text: str) -> ServerHost:
    """Return the address of a rosbridge server, given as ``PORT``, ``HOST:PORT`` or ``ws://HOST:PORT``, or ``wss:``.

    Raises:
        argparse.ArgumentTypeError: It is not such an address.
    """
    if text.isascii() and text.isdigit():
        return ServerHost(*address(f"{DEFAULT_SERVER[0]}:{text}"))
    scheme, separator, rest = text.partition("://")
    if not separator:
        return ServerHost(*address(text))
    place, _, path = rest.partition("/")
    if scheme.lower() not in {"ws", "wss"} or path:
        raise argparse.ArgumentTypeError(f"the door is HOST:PORT, ws:// or wss://HOST:PORT, got {_hidden(text)!r}")
    return ServerHost(*address(place), has_tls=scheme.lower() == "wss")


def server_of_environment() -> ServerHost | None:
    """Return the address in the variable ``HOMEBOT_DOOR``; None if it is not set.

    Raises:
        ConfigError: It is not an address.
    """
    text = os.environ.get("HOMEBOT_DOOR")
    try:
        return server_address(text) if text else None
    except argparse.ArgumentTypeError as exc:
        raise ConfigError("environment", "HOMEBOT_DOOR", str(exc)) from exc


def _is_host(text: str) -> bool:
    if ":" not in text:
        return _HOST.fullmatch(text) is not None
    try:
        return ip_address(text).version == 6
    except ValueError:
        return False


def positive(text: str) -> float:
    """Return the positive number *text*."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not 0 < number < math.inf:
        raise argparse.ArgumentTypeError(f"must be a number above 0, got {text!r}")
    return number


def duration(text: str, most: float = math.inf, least: float = 0.0) -> float:
    """Return the seconds in *text*, a number or a duration such as ``2m``, from *least* to *most*."""
    from homebot.units import parse_duration  # noqa: PLC0415 - loads pydantic

    try:
        length = parse_duration(float(text) if _NUMBER.fullmatch(text) else text)
    except UsageError as exc:
        raise argparse.ArgumentTypeError(str(exc)) from exc
    if not least <= length <= most:
        bounds = f"from {least:g} to {most:g}" if least else f"at most {most:g}"
        raise argparse.ArgumentTypeError(f"must be {bounds} seconds, got {text!r}")
    return length


def seconds(text: str) -> float:
    """Return the seconds in *text* as :func:`duration` does, above 0."""
    length = duration(text)
    if not 0 < length < math.inf:
        raise argparse.ArgumentTypeError(f"must be above 0, got {text!r}")
    return length


def whole(text: str, most: float = math.inf) -> int:
    """Return the positive whole number *text*, up to *most*."""
    if not text.isascii() or not text.isdigit() or not 1 <= int(text) <= most:
        bounds = "above 0" if most == math.inf else f"from 1 to {most:g}"
        raise argparse.ArgumentTypeError(f"must be a whole number {bounds}, got {text!r}")
    return int(text)


def _hidden(text: str) -> str:
    """Return *text* without words that may be passwords."""
    return f"…@{text.rpartition('@')[2]}" if "@" in text else text


def add_server_options(parser: argparse.ArgumentParser, default: str | None = None) -> None:
    """Add the options that select the homebot to connect to; they may come before or after a command."""
    door = parser.add_argument_group("connection to a running homebot")
    door.add_argument(
        "--door",
        metavar="HOST:PORT",
        type=server_address,
        default=default,
        help="address of its rosbridge server (default: [door] of homebot.toml in this folder, else HOMEBOT_DOOR, else "
        f"{DEFAULT_SERVER[0]}:{DEFAULT_SERVER[1]})",
    )
    door.add_argument(
        "--home", metavar="NAME", default=default, help="a home of homes.toml in your configuration folder, not --door"
    )
    door.add_argument(
        "--token-file",
        metavar="FILE",
        default=default,
        help="file with its access token (default: that of [door], else the token in HOMEBOT_DOOR_TOKEN)",
    )
