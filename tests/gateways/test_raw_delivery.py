"""Who gets raw messages: full inboxes, nodes that come and go, and what is forgotten; in virtual time."""

from functools import partial

import anyio
import pytest
from structlog.testing import capture_logs

from homebot.devices import GatewayNames, RawMessage
from homebot.errors import InvalidNameError, RefusedError
from homebot.gateways.raw_delivery import FULL_INBOX_WAIT, PartTexts, RawDelivery
from homebot.graph import Graph, Node, Publisher, Subscription
from homebot.messages import Time

pytestmark = pytest.mark.virtual_time

DEPTH = 3


def message(payload: int) -> RawMessage:
    return RawMessage(
        gateway="fake",
        key="lights/a",
        address="a",
        payload=str(payload).encode(),
        retained=False,
        received_at=Time(sec=0, nanosec=0),
    )


class House:
    """A gateway's listeners, and nodes that listen."""

    def __init__(self, *, inboxes: bool = True) -> None:
        self.graph = Graph()
        self.gateway = Node(self.graph, "fake", namespace="/gateway")
        self.listeners = RawDelivery(self.gateway, GatewayNames("fake"), inboxes=inboxes)

    def listen(self, name: str, address: str = "a") -> tuple[Node, Publisher[RawMessage], Subscription[RawMessage]]:
        node = self.graph.get_node(f"/{name}") or Node(self.graph, name)
        publisher = self.listeners.add(address, f"lights/{address}", address, f"/{name}")
        return node, publisher, node.create_subscription(RawMessage, publisher.topic_name, qos_profile=DEPTH)


def payloads(inbox: Subscription[RawMessage]) -> list[int]:
    found = []
    while (one := inbox.take()) is not None:
        found.append(int(one.payload))
    return found


async def test_a_full_inbox_holds_the_gateway_up_until_it_is_read() -> None:
    """That is how a burst of QoS 1 loses nothing."""
    house = House()
    _, _, inbox = house.listen("app")

    async def deliver() -> None:
        for number in range(10):
            await house.listeners.deliver(message(number), wait_if_full=True)

    found: list[int] = []
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(deliver)
        while len(found) < 10:
            await anyio.sleep(FULL_INBOX_WAIT / 2)
            found += payloads(inbox)
    assert found == list(range(10))


async def test_an_inbox_that_is_never_read_costs_a_moment_a_minute() -> None:
    """Its oldest messages are lost, which is told; the others wait no longer than that."""
    house = House()
    _, _, inbox = house.listen("hanging")
    with capture_logs() as lines:
        for number in range(100):
            await house.listeners.deliver(message(number), wait_if_full=True)
    assert anyio.current_time() == FULL_INBOX_WAIT
    assert payloads(inbox) == [97, 98, 99]
    assert [line["message"] for line in lines] == [
        "/hanging/inbox is full and not being read: its oldest messages are dropped"
    ]
    await anyio.sleep(60)
    for number in range(DEPTH + 1):
        await house.listeners.deliver(message(number), wait_if_full=True)
    assert anyio.current_time() == pytest.approx(60 + 2 * FULL_INBOX_WAIT)


async def test_a_delivery_without_patience_never_waits() -> None:
    """QoS 0."""
    house = House()
    _, _, inbox = house.listen("app")
    for number in range(10):
        await house.listeners.deliver(message(number), wait_if_full=False)
    assert anyio.current_time() == 0
    assert payloads(inbox) == [7, 8, 9]


async def test_a_listener_that_leaves_while_it_is_waited_for_ends_the_wait() -> None:
    """And the gateway goes on."""
    house = House()
    node, _, _ = house.listen("app")

    async def leave() -> None:
        await anyio.sleep(FULL_INBOX_WAIT / 2)
        node.close()
        house.listeners.drop_nodes_that_left()
        assert "a" not in house.listeners.by_address

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(leave)
        for number in range(DEPTH + 1):
            await house.listeners.deliver(message(number), wait_if_full=True)
        assert anyio.current_time() == FULL_INBOX_WAIT / 2
    await house.listeners.deliver(message(0), wait_if_full=True)


async def test_a_listener_that_left_is_forgotten_and_others_are_not() -> None:
    """Also where both listened to one address."""
    house = House()
    gone, _, _ = house.listen("gone")
    house.listen("gone", "b")
    _, stays, _ = house.listen("stays")
    gone.close()
    house.listeners.drop_nodes_that_left()
    assert house.listeners.by_address == {"a": [stays]}
    assert not house.listeners.has("a", "/gone")
    assert house.listeners.has("a", "/stays")


async def test_a_node_that_comes_back_at_once_is_a_new_one() -> None:
    """The news of its end may come after it asked again."""
    house = House()
    node, old, _ = house.listen("app")
    node.close()
    assert not house.listeners.has("a", "/app")
    _, new, inbox = house.listen("app")
    house.listeners.drop_nodes_that_left()
    assert house.listeners.by_address == {"a": [new]} != {"a": [old]}
    await house.listeners.deliver(message(1), wait_if_full=True)
    assert payloads(inbox) == [1]


async def test_in_mirror_mode_askers_share_the_topic_of_the_device() -> None:
    """It stays when one of them leaves."""
    house = House(inboxes=False)
    node, first, _ = house.listen("first")
    _, second, inbox = house.listen("second")
    assert first is second
    assert first.topic_name == "/gateway/fake/received_data/a"
    node.close()
    house.listeners.drop_nodes_that_left()
    await house.listeners.deliver(message(1), wait_if_full=True)
    assert payloads(inbox) == [1]


async def test_an_invalid_listener_is_refused() -> None:
    """A node that is not there; a device whose name makes too long a topic name."""
    house = House()
    with pytest.raises(RefusedError, match="an inbox for /nobody was refused: no such node is on the graph"):
        house.listeners.add("a", "lights/a", "a", "/nobody")
    with pytest.raises(InvalidNameError):
        house.listeners.add("a", "lights/a", "a" * 1000, "")


def test_a_late_text_is_made_when_it_is_asked_for_and_once() -> None:
    """Among those that were made at once it keeps its place, and of all only the last ten are kept."""
    texts, made = PartTexts(), list[int]()

    def make(number: int) -> RawMessage:
        made.append(number)
        return message(number)

    for number in range(12):
        texts.record_lazy(partial(make, number), float(number))
    texts.record(message(12), 12.0, is_event=False)
    assert made == []
    for _ in range(2):
        assert [one.payload for one in texts.missed_by(10.0, 12.0)] == [b"10", b"11", b"12"]
    assert made == list(range(3, 12))


def test_a_part_that_is_described_anew_takes_over_its_texts() -> None:
    """Those that were not made yet as well."""
    before, now = PartTexts(), PartTexts()
    before.record_lazy(lambda: message(1), 1.0)
    before.record(message(2), 2.0, is_event=True)
    now.copy_texts(before)
    assert [one.payload for one in now.missed_by(0.0, 3.0)] == [b"1", b"2"]


async def test_a_retained_message_that_repeats_the_last_is_delivered_once() -> None:
    """A broker sends it on each new link; a new listener has not heard it, and another payload is news."""
    house = House()
    _, _, inbox = house.listen("app")

    async def deliver(payload: int, *, retained: bool) -> None:
        told = message(payload).model_copy(update={"retained": retained})
        await house.listeners.deliver(told, wait_if_full=False)

    await deliver(1, retained=True)
    await deliver(1, retained=True)
    await deliver(1, retained=False)
    assert payloads(inbox) == [1, 1]
    await deliver(1, retained=True)
    await deliver(2, retained=True)
    assert payloads(inbox) == [2]
    _, _, late = house.listen("other")
    await deliver(2, retained=True)
    assert payloads(late) == [2]
