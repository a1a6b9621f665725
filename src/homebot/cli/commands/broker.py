"""``homebot broker``: an MQTT broker until Ctrl-C, SIGTERM or the end of its time."""

import argparse
import math
import ssl
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path

from homebot.cli.arguments import add_log_format, add_time_limit, address, seconds, set_command
from homebot.cli.serve import on_an_event_loop, serve
from homebot.errors import InvalidNameError, UsageError
from homebot.log import configure_logging
from homebot.mqtt.broker import Broker, RefusedFilters
from homebot.mqtt.broker.stats import loss_text
from homebot.mqtt.certificate import load_certificate
from homebot.mqtt.topics import validate_filter
from homebot.support.addresses import is_loopback
from homebot.support.file_access import read_secret
from homebot.support.logger import get_logger
from homebot.support.output import queued_output

SERVING = "broker.serving"
ENDED = "broker.ended"

_log = get_logger(node="/broker")

_EXAMPLES = """\
  homebot broker                                  on 127.0.0.1:1883, for programs on this computer
  homebot broker --listen 127.0.0.1:0             on a free port, which the first line shows
  homebot broker --listen 0.0.0.0:1883 --user home --password-file broker.password
                                                  for other devices of the home too
  homebot broker --listen 0.0.0.0:8883 --user home --password-file broker.password \\
                 --tls-cert broker.pem --tls-key broker.key
                                                  the same, with TLS

Sessions and retained messages are kept in memory only: they are lost when the broker stops. Ctrl-C stops it.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_command(parser, broker, _EXAMPLES)
    parser.add_argument(
        "--listen",
        metavar="HOST:PORT",
        type=partial(address, example=1883),
        default=("127.0.0.1", 1883),
        help="address to listen on; port 0 picks a free one (default: 127.0.0.1:1883)",
    )
    parser.add_argument(
        "--keep-alive",
        metavar="TIME",
        type=seconds,
        help="longest keep-alive allowed for an MQTT 5 client; a longer one is shortened",
    )
    parser.add_argument(
        "--refuse-filter",
        metavar="FILTER",
        action="append",
        default=[],
        help="refuse subscriptions to exactly this filter (reason code 0x80), to test how a client reacts; may be "
        "given more than once",
    )
    parser.add_argument("--user", metavar="NAME", help="user name for clients; needs --password-file")
    parser.add_argument("--password-file", metavar="FILE", type=Path, help="file whose first line is the password")
    parser.add_argument("--tls-cert", metavar="FILE", type=Path, help="certificate for TLS (PEM)")
    parser.add_argument(
        "--tls-key", metavar="FILE", type=Path, help="private key for TLS (PEM), unless --tls-cert contains it"
    )
    add_log_format(parser)
    add_time_limit(parser)


def broker(options: argparse.Namespace) -> int:
    """Run until told to stop; return 0."""
    made = make_broker(options)
    with queued_output():
        configure_logging(options.log_format)
        on_an_event_loop(serve(_running(made), options.seconds))
    return 0


def make_broker(options: argparse.Namespace) -> Broker:
    """Return the broker with these *options*, not listening yet.

    Raises:
        UsageError: Options contradict each other, a value is wrong, or a file cannot be used.
    """
    host, port = options.listen
    credentials = None
    if options.user is not None or options.password_file is not None:
        if not options.user or options.password_file is None:
            raise UsageError("give --user and --password-file together")
        credentials = {options.user: read_secret(options.password_file)}
    if credentials is None and not is_loopback(host):
        raise UsageError(
            f"{host} can be reached by others, so it needs a password: give --user and --password-file, "
            "or listen on 127.0.0.1"
        )
    for name in options.refuse_filter:
        try:
            validate_filter(name)
        except InvalidNameError as exc:
            raise UsageError(f"--refuse-filter: {exc}") from exc
    return Broker(
        host=host,
        port=port,
        credentials=credentials,
        tls=_tls(options),
        keep_alive=options.keep_alive and math.ceil(options.keep_alive),
        policy=RefusedFilters(options.refuse_filter),
    )


def _tls(options: argparse.Namespace) -> ssl.SSLContext | None:
    if options.tls_cert is None:
        if options.tls_key is not None:
            raise UsageError("--tls-key needs --tls-cert")
        return None
    context = ssl.create_default_context(ssl.Purpose.CLIENT_AUTH)
    load_certificate(context, options.tls_cert, options.tls_key, what="certificate", key_option="--tls-key")
    return context


@asynccontextmanager
async def _running(broker: Broker) -> AsyncIterator[None]:
    async with broker:
        _log.info(SERVING, message=f"MQTT broker listening on {broker.url}; press Ctrl-C to stop", url=broker.url)
        yield
    stats = broker.stats
    losses = loss_text(broker.state.counters)
    lost = f", dropped {losses}" if losses else ""
    _log.info(
        ENDED,
        message=f"the broker stopped; received {stats.messages_received} messages on "
        f"{stats.connections_accepted} connections, sent {stats.messages_sent}{lost}",
        connections=stats.connections_accepted,
        messages_received=stats.messages_received,
        messages_sent=stats.messages_sent,
    )
