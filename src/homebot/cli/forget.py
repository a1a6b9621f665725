"""The arguments of ``homebot forget``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_command

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot forget lights/roomlights405
  homebot forget 'Kitchen lamp' --purge

A forgotten device comes back when it sends a message or is announced again.
"""


def add_parser(commands: Commands) -> None:
    """Add ``forget``."""
    parser = add_command(
        commands, "forget", "remove a device from the index", _EXAMPLES, "homebot.cli.commands.forget:forget"
    )
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument(
        "--purge",
        action="store_true",
        help="also delete its retained announcements from the broker, so that no program finds it any more",
    )
