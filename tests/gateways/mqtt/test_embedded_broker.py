"""The broker that homebot brings along: on the usual port, or the next free one."""

import socket
from contextlib import ExitStack

import pytest
from structlog.testing import capture_logs
from tests.ports import reserve_port

from homebot.clock import LoopClock
from homebot.devices.health import GetHealth, HealthRequest
from homebot.errors import LinkError
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.gateways.mqtt.embedded_broker import embedded_broker
from homebot.gateways.mqtt.settings import USUAL_PORTS
from homebot.graph import Graph, Node
from homebot.mqtt.clients import HostedBroker


async def test_where_all_usual_ports_are_taken_any_free_one_does() -> None:
    """And the log says which."""
    with ExitStack() as stack, capture_logs() as lines:
        others = [stack.enter_context(socket.create_server(("127.0.0.1", 0))) for _ in range(2)]
        ports = [one.getsockname()[1] for one in others]
        async with embedded_broker(Graph(LoopClock()), LoopClock(), ports=(*ports, 0)) as broker:
            assert broker.port not in ports
    (told,) = [line["message"] for line in lines if line["event"] == "runtime.broker_started"]
    assert told == f"embedded MQTT broker on {broker.url} (port {ports[0]} was taken)"


async def test_the_first_free_one_of_the_usual_ports_is_taken() -> None:
    """1883 is the port that MQTT clients try first."""
    assert USUAL_PORTS[0] == 1883
    with socket.create_server(("127.0.0.1", 0)) as other, capture_logs() as lines:
        ports = [other.getsockname()[1], reserve_port()]
        async with embedded_broker(Graph(LoopClock()), LoopClock(), ports=ports[1:]) as broker:
            assert broker.port == ports[1]
        async with embedded_broker(Graph(LoopClock()), LoopClock(), ports=ports) as broker:
            assert broker.port == ports[1]
    told = [line["message"] for line in lines if line["event"] == "runtime.broker_started"]
    assert told == [
        f"embedded MQTT broker on {broker.url}",
        f"embedded MQTT broker on {broker.url} (port {ports[0]} was taken)",
    ]


async def test_a_chosen_port_that_is_taken_is_told_and_no_other_is_used() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        (chosen,) = MqttGateway.host_services(MqttGatewaySettings(url=f"embedded:{port}"))
        with pytest.raises(LinkError, match=f"port {port} is taken"):
            async with chosen.start(Graph(LoopClock()), LoopClock()):
                pass
    async with chosen.start(Graph(LoopClock()), LoopClock()) as broker:
        assert isinstance(broker, HostedBroker)
        assert broker.url == f"mqtt://127.0.0.1:{port}"


async def test_its_counts_and_losses_are_on_the_graph() -> None:
    """`homebot doctor` asks every service of this type."""
    graph = Graph(LoopClock())
    async with embedded_broker(graph, LoopClock()) as broker, Node(graph, "asker") as node:
        client = node.create_client(GetHealth, "/broker/health")
        well = await client.call(HealthRequest())
        assert well.troubles == ()
        assert {one.name: one.count for one in well.counts}["dropped_offline"] == 0
        broker.state.counters.dropped_offline += 5
        ill = await client.call(HealthRequest())
    assert ill.troubles == ("in the last ten minutes it dropped 5 messages (5 for clients that were away too long)",)
    assert {one.name: one.count for one in ill.counts}["dropped_offline"] == 5
