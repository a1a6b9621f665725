"""``homebot top``."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from typing import Final

from homebot.cli.arguments import set_client_command
from homebot.cli.door_client import DoorClient, door_command
from homebot.cli.load_rows import HEADINGS, Load
from homebot.cli.terminal import is_terminal, print_line, print_table, show_live

__all__ = ["add_arguments", "samples"]

_FRAME: Final = 0.5
_SAMPLE: Final = 1.0
_SORTED_EVERY: Final = 10
"""Frames after which topics are sorted anew, so that lines do not jump."""

_EXAMPLES = """\
  homebot top
  homebot top --json | jq .lag

For each topic: messages in a second, how many wait in its fullest queue, how many were lost since the start, and how
long its slowest handler took since the frame before. Until Ctrl-C on a terminal; elsewhere one table.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot top``."""
    set_client_command(parser, _top, _EXAMPLES)
    parser.add_argument("--json", action="store_true", help="print a JSON object a second, until Ctrl-C")


def samples(ask: Callable[[], dict[str, object]], wait: Callable[[], None]) -> Iterator[Load]:
    """Yield the load since the sample before, for ever.

    Args:
        ask: Returns the answer of ``/rosapi/load``.
    """
    before = ask()
    while True:
        wait()
        after = ask()
        yield Load.between(before, after)
        before = after


@door_command
def _top(door: DoorClient, options: argparse.Namespace) -> int:
    """Show the load."""
    is_live = is_terminal() and not options.json

    def wait() -> None:
        for _ in door.until(_FRAME if is_live else _SAMPLE):
            pass

    found = samples(lambda: door.call("/rosapi/load"), wait)
    if is_live:
        show_live(HEADINGS, _frames(found, f"{door.home} on {door.where}"), if_wide=("BY", "SLOWEST", "WAITING"))
        return 0
    for load in found:
        if not options.json:
            print_table(HEADINGS, [one.cells() for one in load.rows])
            print_line(load.title)
            break
        print(json.dumps(load.as_json()), flush=True)
    return 0


def _frames(found: Iterator[Load], where: str) -> Iterator[tuple[str, list[tuple[str, ...]]]]:
    """Yield the title and the rows of each frame."""
    order: list[str] = []
    for number, load in enumerate(found):
        if number % _SORTED_EVERY == 0:
            order = [one.topic for one in load.rows]
        yield f"{where}: {load.title}", [one.cells() for one in load.in_order_of(order)]
