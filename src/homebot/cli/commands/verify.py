"""``homebot verify``."""

import argparse
from functools import partial

from homebot.cli.arguments import set_client_command
from homebot.cli.commands.identify import add_options, identify

_EXAMPLES = """\
  homebot verify 'Hall lamp' --with /rosie/light

Exit code 0 means that this is the device that the sensor sees; 1 that it is not, or not surely.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_client_command(parser, partial(identify, is_check=True), _EXAMPLES, acts=True)
    parser.add_argument("candidates", metavar="DEVICE", help="the id or name of the device")
    add_options(parser)
