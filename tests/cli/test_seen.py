"""``homebot seen``."""

import pytest
from tests.cli.conftest import HomebotWith, run_at

from homebot.clock import ManualClock
from homebot.features.alerts import SEE_ALERTS
from homebot.graph import Graph, Node
from homebot.messages.std_srvs import SuccessResponse, Trigger, TriggerRequest


def test_the_alerts_of_now_are_seen_from_the_command_line(
    homebot_with: HomebotWith, capsys: pytest.CaptureFixture[str]
) -> None:
    seen: list[TriggerRequest] = []

    def see(request: TriggerRequest) -> SuccessResponse:
        seen.append(request)
        return SuccessResponse(success=True, message="")

    def alerts(graph: Graph) -> Node:
        node = Node(graph, "alerts")
        node.create_service(Trigger, SEE_ALERTS.name, see)
        return node

    run = run_at(homebot_with(alerts, ManualClock(0)), capsys)
    assert run("seen") == (0, "nobody is told of it again\n")
    assert len(seen) == 1
