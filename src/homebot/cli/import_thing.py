"""The arguments of ``homebot import``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_command, positive

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot import desk_lamp.td.json
  homebot import desk_lamp.td.json --name desk-lamp

The description is published as a retained message on homebot/things/NAME/td, and the gateway makes a device of it,
which stays until `homebot forget DEVICE --purge`. Its MQTT forms with JSON or plain text can be read and written.
"""


def add_parser(commands: Commands) -> None:
    """Add ``import``."""
    parser = add_command(
        commands,
        "import",
        "add a device from a W3C Thing Description",
        _EXAMPLES,
        "homebot.cli.commands.import_thing:import_thing",
    )
    parser.add_argument("file", metavar="FILE", help="Thing Description 1.1, as JSON")
    parser.add_argument(
        "--name", metavar="NAME", default="", help="NAME in its topic (default: made from its id or title)"
    )
    parser.add_argument(
        "--prefix", metavar="P", default="homebot/things", help="first levels of its topic (default: homebot/things)"
    )
    parser.add_argument(
        "--gateway", metavar="G", default="mqtt", help="gateway that is connected to its broker (default: mqtt)"
    )
    parser.add_argument(
        "--timeout", metavar="S", type=positive, default=5.0, help="seconds to wait for the device (default: 5)"
    )
