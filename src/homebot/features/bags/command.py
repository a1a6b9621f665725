"""``homebot bag``: ``record``, ``play``, ``info``, ``recover`` and ``export``."""

import argparse
from collections.abc import Callable
from importlib import import_module
from typing import Final

from homebot.cli.arguments import Commands, add_time_limit, add_verb, add_verbs, positive, seconds, set_command, whole
from homebot.cli.door_client import set_door_command
from homebot.plugins import check_extra

_EXAMPLES: Final = """\
  homebot bag record -o day
  homebot bag info day
  homebot bag play day --rate 2
"""
_RECORD_EXAMPLES: Final = """\
  homebot bag record
  homebot bag record /rosie/** /map -o day.mcap
  homebot bag record -o day --exclude /rosout --max-size 100000000 --max-duration 3600

Topics are recorded as they come, until Ctrl-C. The bag shows when people were at home, so only you can read it.
"""
_PLAY_EXAMPLES: Final = """\
  homebot bag play day
  homebot bag play day --rate 10 --topics '/rosie/**' /map

Topics of homebot itself are only played if --topics names them, and commands to devices and robots with --commands.
"""
_PATTERNS: Final = "; * is within a part of the name, ** any number of parts"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    _add_record(verbs)
    _add_play(verbs)
    command = add_verb(verbs, "info", "show the topics, messages and duration of a bag")
    command.add_argument("bag", metavar="BAG", help="folder, or file that ends in .mcap")
    set_command(command, _later("files", "info"), "  homebot bag info day\n  homebot bag info day/day_0.mcap\n")
    command = add_verb(verbs, "recover", "copy what is whole in a bag that was cut off or damaged")
    command.add_argument("bag", metavar="BAG", help="folder, or file that ends in .mcap")
    command.add_argument("new", metavar="NEW", help="bag to write, likewise")
    set_command(command, _later("files", "recover"), "  homebot bag recover day whole\n")
    command = add_verb(verbs, "export", "write a recording of `homebot record` as a bag")
    command.add_argument("recording", metavar="RECORDING", help="file of `homebot record`")
    command.add_argument("new", metavar="NEW", help="bag to write: a folder, or a file that ends in .mcap")
    set_command(command, _later("files", "export"), "  homebot bag export day.jsonl.gz day\n")


def _add_record(verbs: Commands) -> None:
    command = add_verb(verbs, "record", "record topics into a bag")
    command.add_argument("topics", metavar="TOPIC", nargs="*", type=_pattern, help=f"topics (default: all){_PATTERNS}")
    command.add_argument(
        "-o", "--output", metavar="BAG", default="", help="folder, or file that ends in .mcap (default: rosbag2_TIME)"
    )
    command.add_argument(
        "-x", "--exclude", metavar="TOPIC", nargs="+", type=_pattern, default=[], help="topics to leave out, likewise"
    )
    add_time_limit(command)
    command.add_argument("--max-size", metavar="BYTES", type=whole, default=0, help="begin the next file after BYTES")
    command.add_argument("--max-duration", metavar="TIME", type=seconds, default=0.0, help="likewise after TIME")
    set_door_command(command, _later("recording", "record"), _RECORD_EXAMPLES)


def _add_play(verbs: Commands) -> None:
    command = add_verb(verbs, "play", "publish the messages of a bag at the times that they had")
    command.add_argument("bag", metavar="BAG", help="folder, or file that ends in .mcap")
    command.add_argument("-r", "--rate", metavar="N", type=positive, default=1.0, help="play N times as fast")
    command.add_argument(
        "--topics", metavar="TOPIC", nargs="+", type=_pattern, default=[], help=f"topics to play{_PATTERNS}"
    )
    command.add_argument("--commands", action="store_true", help="play commands to devices and robots too")
    set_door_command(command, _later("playing", "play"), _PLAY_EXAMPLES, acts=True)


def _pattern(text: str) -> str:
    return f"/{text.removeprefix('/')}"


def _later(module: str, function: str) -> Callable[..., int]:
    """Return a command with a *module* that is loaded when it runs, as the libraries are slow, or missing."""

    def run(*arguments: object) -> int:
        check_extra("homebot bag", "mcap", "mcap", "yaml", "zstandard")
        code: int = getattr(import_module(f"homebot.features.bags.command_{module}"), function)(*arguments)
        return code

    return run
