"""The arguments of ``homebot show``."""

from __future__ import annotations

from homebot.cli.arguments import Commands, add_broker_option, add_command

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot show lights/roomlights405
  homebot show 'Kitchen lamp'
  homebot show 'Kitchen lamp' --td > kitchen_lamp.td.json
"""


def add_parser(commands: Commands) -> None:
    """Add ``show``."""
    parser = add_command(
        commands, "show", "show everything known about a device", _EXAMPLES, "homebot.cli.commands.show:show"
    )
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="print a JSON object, times in ISO 8601 UTC")
    form.add_argument("--td", action="store_true", help="print a W3C Thing Description 1.1")
    add_broker_option(parser)
