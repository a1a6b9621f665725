"""The arguments of ``homebot broker``."""

from __future__ import annotations

from pathlib import Path

from homebot.cli.arguments import Commands, add_plain_command, address, positive, whole

__all__ = ["add_parser"]

_EXAMPLES = """\
  homebot broker                                  on 127.0.0.1:1883, for programs on this computer
  homebot broker --listen 127.0.0.1:0             on a free port, which the first line shows
  homebot broker --listen 0.0.0.0:1883 --user home --password-file broker.password
                                                  for other devices of the home as well
  homebot broker --listen 0.0.0.0:8883 --user home --password-file broker.password \\
                 --tls-cert broker.pem --tls-key broker.key
                                                  the same, with TLS

Sessions and retained messages are kept in memory only: they are lost when the broker stops. Ctrl-C stops it.
"""


def add_parser(commands: Commands) -> None:
    """Add ``broker`` to *commands*."""
    parser = add_plain_command(
        commands, "broker", "run an MQTT broker and nothing else", _EXAMPLES, "homebot.cli.commands.broker:broker"
    )
    parser.add_argument(
        "--listen",
        metavar="HOST:PORT",
        type=address,
        default=("127.0.0.1", 1883),
        help="address to listen on; port 0 picks a free one (default: 127.0.0.1:1883)",
    )
    parser.add_argument(
        "--keep-alive",
        metavar="SECONDS",
        type=whole,
        help="longest keep-alive allowed to an MQTT 5 client; a longer one is shortened",
    )
    parser.add_argument(
        "--refuse-filter",
        metavar="FILTER",
        action="append",
        default=[],
        help="answer a subscription to exactly this filter with 0x80; may be given more than once",
    )
    parser.add_argument("--user", metavar="NAME", help="user name for clients; needs --password-file")
    parser.add_argument("--password-file", metavar="FILE", type=Path, help="file whose first line is the password")
    parser.add_argument("--tls-cert", metavar="FILE", type=Path, help="certificate for TLS (PEM)")
    parser.add_argument(
        "--tls-key", metavar="FILE", type=Path, help="private key for TLS (PEM), unless --tls-cert contains it"
    )
    parser.add_argument(
        "--log-format",
        choices=("console", "json"),
        default="console",
        help="log lines for people (console) or programs (json)",
    )
    parser.add_argument("--for", dest="seconds", metavar="SECONDS", type=positive, help="stop after this many seconds")
