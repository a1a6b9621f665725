"""Other brokers that connect as bridges and say so, as Mosquitto does where it is not told otherwise."""

from functools import partial

import pytest
from tests.mqtt.broker.conformance.conftest import Meet

from homebot.mqtt.packets import ProtocolVersion, ReasonCode


@pytest.fixture(params=[ProtocolVersion.V31, ProtocolVersion.V311], ids=["3.1", "3.1.1"])
def meet(request: pytest.FixtureRequest, meet: Meet) -> Meet:
    """Of a version before 5."""
    return partial(meet, version=request.param)


def test_a_bridge_is_let_in_and_not_sent_what_it_published_itself(meet: Meet) -> None:
    """Else each message that is bridged both ways would come back, and go round for ever."""
    bridge, client = meet("bridge", is_bridge=True), meet("client")
    assert bridge.connack.reason is ReasonCode.SUCCESS
    bridge.subscribe("house/#")
    client.subscribe("house/#")
    bridge.publish("house/a", b"bridged", 1)
    client.publish("house/b", b"local", 1)
    bridge.settle(client)
    assert bridge.payloads == [b"local"]
    assert client.payloads == [b"bridged", b"local"]


def test_a_bridge_is_told_what_is_retained_as_it_was_published(meet: Meet) -> None:
    """Else nothing would be retained at its own broker but what was there when it subscribed."""
    bridge, client = meet("bridge", is_bridge=True), meet("client")
    bridge.subscribe("house/#")
    client.subscribe("house/#")
    client.publish("house/a", b"kept", 1, retain=True)
    client.publish("house/a", b"passing", 1)
    bridge.settle(client)
    assert [each.retain for each in bridge.messages] == [True, False]
    assert [each.retain for each in client.messages] == [False, False]


def test_a_bridge_may_take_part_in_a_shared_subscription(meet: Meet) -> None:
    """There it is sent its own as well: MQTT 5 does not allow both together."""
    bridge = meet("bridge", is_bridge=True)
    assert not bridge.subscribe("$share/g/house/#").reasons[0].failed
    bridge.publish("house/a", b"own", 1)
    assert bridge.payloads == [b"own"]


def test_what_a_bridge_is_owed_while_it_is_away_leaves_out_its_own_too(meet: Meet) -> None:
    bridge, client = meet("bridge", clean=False, is_bridge=True), meet("client")
    bridge.subscribe("house/#")
    bridge.leave()
    client.publish("house/a", b"meanwhile", 1)
    bridge = meet("bridge", clean=False, is_bridge=True)
    bridge.publish("house/a", b"own", 1)
    assert bridge.payloads == [b"meanwhile"]
