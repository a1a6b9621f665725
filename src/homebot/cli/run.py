"""The arguments of ``homebot run``."""

from __future__ import annotations

import os

from homebot.cli.arguments import Commands, add_plain_command, address, app, positive

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot run                                     embedded broker, a small simulated house, the light service
  homebot run --for 15                            the same, for 15 seconds
  homebot run --house family.toml                 the same, with a house that you describe
  homebot run --mqtt mqtt://192.168.1.10 --root home425      your own broker, only observing
  homebot run --mqtt mqtt://192.168.1.10 --root home425 --act --app light_service    act, with an app that you name
  homebot run --app my_app:MyApp                  an app of your own instead of the light service
  homebot run --config homebot.toml               everything set in a file

Without --config, homebot.toml in the working directory is used if it exists. Ctrl-C stops everything in order.
Devices are remembered in HOMEBOT_DATA (default: the user's data directory), but not those of a simulated house.
"""


def add_parser(commands: Commands) -> None:
    """Add ``run`` to *commands*."""
    parser = add_plain_command(
        commands,
        "run",
        "run homebot: find the devices of a house and act on them",
        _EXAMPLES,
        "homebot.cli.commands.run:run",
    )
    parser.add_argument(
        "--config", metavar="FILE", help="configuration file in TOML (default: homebot.toml, if it exists)"
    )
    parser.add_argument(
        "--house",
        metavar="FILE",
        help="simulated house in TOML, on the embedded broker (default: a small one, without --config and --mqtt)",
    )
    parser.add_argument("--mqtt", metavar="URL", help="broker of the gateway `mqtt`, as mqtt://[user@]host[:port]")
    parser.add_argument("--root", metavar="NAME", help="home to listen to, which is the first level of its MQTT topics")
    parser.add_argument(
        "--app",
        metavar="NAME",
        type=app,
        action="append",
        default=[],
        help="app to run, a plug-in's name or module:Class; may be given more than once (default: the light service "
        "in the simulated house, none on a broker of your own)",
    )
    parser.add_argument(
        "--act", action="store_true", help="allow the gateway `mqtt` to send commands to an outside broker"
    )
    parser.add_argument(
        "--door",
        metavar="HOST:PORT",
        type=address,
        default=os.environ.get("HOMEBOT_DOOR"),
        help="address to listen on for rosbridge clients (default: HOMEBOT_DOOR, else 127.0.0.1:9090)",
    )
    parser.add_argument(
        "--log-format",
        choices=("console", "json"),
        default="console",
        help="log lines for people (console) or programs (json)",
    )
    parser.add_argument("--ephemeral", action="store_true", help="do not remember devices across restarts")
    parser.add_argument("--for", dest="seconds", metavar="SECONDS", type=positive, help="stop after this many seconds")
