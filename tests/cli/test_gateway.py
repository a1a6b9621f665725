"""``homebot gateway``."""

from collections.abc import Callable

import pytest
from tests.cli.conftest import Run
from tests.cli.test_places import index_node

from homebot.devices.gateway_messages import (
    GatewayState,
    RestartGateway,
    RestartGatewayRequest,
    RestartGatewayResponse,
)
from homebot.devices.names import RESTART_GATEWAY, GatewayNames
from homebot.discovery import DeviceIndex
from homebot.graph import Graph, Node, qos_profile_latched


def home(graph: Graph) -> Node:
    """A home with a gateway that is away."""

    def restart(request: RestartGatewayRequest) -> RestartGatewayResponse:
        known = request.gateway == "radio"
        return RestartGatewayResponse(success=known, message="radio starts again" if known else "there is no such one")

    states = Node(graph, "radio", namespace="/gateway").create_publisher(
        GatewayState, GatewayNames("radio").state, qos_profile_latched
    )
    states.publish(GatewayState(state="unavailable", reason="no radio", acts=True))
    Node(graph, "homebot").create_service(RestartGateway, RESTART_GATEWAY, restart)
    return index_node(DeviceIndex(forget_after=1000.0), graph, ())


@pytest.fixture
def run(run_with: Callable[..., Run]) -> Run:
    return run_with(home)


def test_gateways_are_listed_and_restarted(run: Run) -> None:
    assert run("gateway", "list") == (0, "gateway radio is unavailable: no radio\n")
    assert run("gateway", "restart", "radio") == (0, "radio starts again\n")
    assert run("gateway", "restart", "radoi") == (1, "homebot: there is no such one\n")
