"""The arguments of ``homebot devices``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_broker_option, add_command

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot devices
  homebot devices --type lights
  homebot devices --json
  homebot devices --td things/

STATE is what the device last reported. COMMAND TOPIC is where it takes commands, empty if it takes none; send one with
`homebot topic pub --once /gateway/mqtt/out '{address: home/lights/lamp/in, payload: off}'`. AVAILABILITY is `fresh`
if the device reported recently, `unconfirmed` if it is known only from a retained message or the index file, `stale`
if it has been silent for too long, `unreachable` if it or its last will says offline, and `partly unreachable` if
only some of its parts are.
"""


def add_parser(commands: Commands) -> None:
    """Add ``devices``."""
    parser = add_command(
        commands, "devices", "list the devices in the house", _EXAMPLES, "homebot.cli.commands.devices:list_devices"
    )
    parser.add_argument("--type", metavar="T", default="", help="only devices of this type, for example lights")
    parser.add_argument("--td", metavar="DIR", help="write a W3C Thing Description of each device to this directory")
    add_broker_option(parser)
    parser.add_argument("--json", action="store_true", help="print a JSON list, times in ISO 8601 UTC")
