"""What the log hears of clients, and how much."""

from __future__ import annotations

from structlog.testing import capture_logs

from homebot.bridges.client_error_log import ClientErrorLog
from homebot.clock import ManualClock
from homebot.graph import Graph, Node


async def test_mistakes_of_many_clients_are_told_and_a_flood_of_them_is_counted() -> None:
    clock = ManualClock()
    error_log = ClientErrorLog(Node(Graph(clock), "door"))
    with capture_logs() as logs:
        for number in range(25):
            error_log.log("refused 10.0.0.1", "door.refused", f"10.0.0.1:{number} did wrong")
        error_log.log("refused 10.0.0.2", "door.refused", "10.0.0.2:1 did wrong")
        clock.advance(10)
        error_log.log("refused 10.0.0.1", "door.refused", "10.0.0.1:99 did wrong")
    assert len(logs) == 22
    assert logs[-2]["message"] == "10.0.0.2:1 did wrong"
    assert logs[-1]["message"] == "10.0.0.1:99 did wrong (and 5 more like this)"
    assert logs[-1]["held_back"] == 5
