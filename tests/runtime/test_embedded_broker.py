"""The broker that homebot brings along: on the usual port, or the next free one."""

from __future__ import annotations

import socket
from contextlib import ExitStack, suppress

from structlog.testing import capture_logs

from homebot.clock import LoopClock
from homebot.runtime.embedded_broker import FIRST_PORT, NEIGHBOURS, embedded_broker


async def test_where_all_usual_ports_are_taken_any_free_one_does() -> None:
    """And the log says which."""
    with ExitStack() as stack, capture_logs() as lines:
        for port in range(FIRST_PORT, FIRST_PORT + NEIGHBOURS):
            with suppress(OSError):  # somebody else's: taken as well
                stack.enter_context(socket.create_server(("127.0.0.1", port)))
        async with embedded_broker(LoopClock()) as broker:
            assert broker.port not in range(FIRST_PORT, FIRST_PORT + NEIGHBOURS)
    (told,) = [line["message"] for line in lines if line["event"] == "runtime.broker_started"]
    assert told == f"embedded MQTT broker on {broker.url} (port 1883 was taken)"
