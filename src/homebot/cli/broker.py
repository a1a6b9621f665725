"""The arguments of ``homebot broker``."""

from __future__ import annotations

from pathlib import Path

from homebot.cli.arguments import Commands, add_plain_command, address, positive, whole

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot broker                                  on 127.0.0.1:1883, for programs on this computer
  homebot broker --listen 127.0.0.1:0             on a free port; the first line says which
  homebot broker --listen 0.0.0.0:1883 --user home --password-file broker.password
                                                  for the devices of a home too
  homebot broker --listen 0.0.0.0:8883 --user home --password-file broker.password \\
                 --tls-cert broker.pem --tls-key broker.key
                                                  the same, encrypted

Sessions and retained messages live in memory: they end with the broker. Ctrl-C stops it in order.
"""


def add_parser(commands: Commands) -> None:
    """Add ``broker`` to *commands*."""
    parser = add_plain_command(
        commands, "broker", "run an MQTT broker, alone", _EXAMPLES, "homebot.cli.commands.broker:broker"
    )
    parser.add_argument(
        "--listen",
        metavar="HOST:PORT",
        type=address,
        default=("127.0.0.1", 1883),
        help="where clients come in; port 0 is any free one (default: 127.0.0.1:1883)",
    )
    parser.add_argument(
        "--keep-alive",
        metavar="SECONDS",
        type=whole,
        help="longest keep-alive that an MQTT 5 client may have; a longer one is replaced",
    )
    parser.add_argument(
        "--refuse-filter",
        metavar="FILTER",
        action="append",
        default=[],
        help="answer a subscription to exactly this filter with 0x80; may be given more than once",
    )
    parser.add_argument("--user", metavar="NAME", help="user that may log in; needs --password-file")
    parser.add_argument("--password-file", metavar="FILE", type=Path, help="file whose first line is the password")
    parser.add_argument("--tls-cert", metavar="FILE", type=Path, help="speak TLS with this certificate (PEM)")
    parser.add_argument(
        "--tls-key", metavar="FILE", type=Path, help="its key (PEM), unless --tls-cert holds it as well"
    )
    parser.add_argument(
        "--log-format", choices=("console", "json"), default="console", help="lines for people or for programs"
    )
    parser.add_argument("--for", dest="seconds", metavar="SECONDS", type=positive, help="stop after this time")
