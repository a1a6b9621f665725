"""``homebot seen``."""

import argparse
from typing import Final

from homebot.cli.door_client import DoorClient, set_door_command
from homebot.features.alerts import SEE_ALERTS

_EXAMPLES: Final = """\
  homebot seen    nobody is told again of the alerts that last now; `homebot doctor` lists them
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _see, _EXAMPLES)


def _see(door: DoorClient, _: argparse.Namespace) -> int:
    door.ask(SEE_ALERTS.name, {})
    print("nobody is told of it again")
    return 0
