"""The arguments of ``homebot devices``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_broker_option, add_command

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot devices
  homebot devices --type lights
  homebot devices --json
  homebot devices --td things/

SAYS is what a device last told of itself. LISTENS ON is where it takes commands: publish there what it understands,
as in `homebot topic pub --once /gateway/mqtt/out '{address: home/lights/lamp/in, payload: off}'`; empty where it
takes none. STATE is `fresh` where it spoke itself, `unconfirmed` where only a message that the broker had kept or the
index file speaks for it, `stale` where it has been silent for too long; and `unreachable` where it or its last will
says that, `partly unreachable` where that is so of some of its parts.
"""


def add_parser(commands: Commands) -> None:
    """Add ``devices``."""
    parser = add_command(
        commands, "devices", "list the devices in the house", _EXAMPLES, "homebot.cli.commands.devices:list_devices"
    )
    parser.add_argument("--type", metavar="T", default="", help="only those that offer this, for example lights")
    parser.add_argument("--td", metavar="DIR", help="write a W3C Thing Description of each into this directory")
    add_broker_option(parser)
    parser.add_argument("--json", action="store_true", help="print a JSON list, times in ISO 8601 UTC")
