"""The receiving half that all adapters share."""

from collections.abc import Callable

import anyio
import pytest
from anyio import wait_all_tasks_blocked
from hypothesis import given
from hypothesis import strategies as st
from structlog.testing import capture_logs

from homebot.clock import ManualClock
from homebot.errors import LinkError
from homebot.mqtt.client import SessionGrant
from homebot.mqtt.client.login import MqttVersion
from homebot.mqtt.client.receiver import DeliveryLedger, Frame, Inbox, Receiver
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import Properties

BAD = Frame(0x32, b"\x00\x02\xc3\x28\x00\x07")


def make(
    clock: ManualClock | None = None,
    *,
    inbox_messages: int = 10,
    protocol: MqttVersion = "3.1.1",
    write: Callable[[bytes], object] = len,
) -> Receiver:
    receiver = Receiver(MqttOptions(host="broker", inbox_messages=inbox_messages), clock or ManualClock())
    receiver.begin_link(SessionGrant(resumed=False, protocol=protocol), write)
    return receiver


async def test_a_publish_becomes_a_message_that_can_be_acknowledged() -> None:
    written: list[bytes] = []
    receiver = make(write=written.append)
    assert receiver.publish(Frame(0x33, b"\x00\x03a/b\x12\x34x")) == b""
    receiver.deliver()
    messages = await receiver.receive()
    assert messages == [MqttMessage("a/b", b"x", 1, retain=True)]
    receiver.ack(messages)
    receiver.end_link(LinkError("lost"))
    receiver.ack(messages)
    assert written == [b"\x40\x02\x12\x34"]


async def test_a_publish_of_mqtt_5_has_properties() -> None:
    receiver = make(protocol="5")
    receiver.publish(
        Frame(
            0x32,
            bytes.fromhex(
                "00 03 61 2f 62 00 07"  # topic a/b, identifier 7
                "23 01 01 02 00 00 00 3c 03 00 02 74 70 08 00 01 72 09 00 02 ff 00"
                "26 00 01 6b 00 01 76 26 00 01 6b 00 01 77"
                "6869"
            ),
        )
    )
    receiver.deliver()
    properties = Properties(
        payload_format_indicator=1,
        message_expiry_interval=60,
        content_type="tp",
        response_topic="r",
        correlation_data=b"\xff\x00",
        user_properties=(("k", "v"), ("k", "w")),
    )
    assert await receiver.receive() == [MqttMessage("a/b", b"hi", 1, properties=properties)]


async def test_a_publish_of_qos_0_with_the_flag_of_a_repetition_is_taken() -> None:
    receiver = make()
    receiver.publish(Frame(0x38, b"\x00\x01tx"))
    receiver.deliver()
    assert await receiver.receive() == [MqttMessage("t", b"x")]


@pytest.mark.parametrize("body", ["", "00 00 03 23 00 01", "00 01 61 02 7f 00"], ids=["no topic", "alias", "property"])
def test_a_bad_publish_is_counted(body: str) -> None:
    receiver = make(protocol="5")
    assert receiver.publish(Frame(0x30, bytes.fromhex(body))) == b""
    assert receiver.counters.dropped_malformed == 1


@given(first=st.integers(0x30, 0x3F), body=st.binary(max_size=60), protocol=st.sampled_from(("5", "3.1.1")))
def test_any_bytes_are_a_message_or_counted(first: int, body: bytes, protocol: MqttVersion) -> None:
    receiver = make(protocol=protocol)
    receiver.publish(Frame(first, body))
    receiver.deliver()
    assert receiver.counters.received + receiver.counters.dropped_malformed == 1


def test_a_flood_of_bad_messages_is_counted_in_full_and_logged_now_and_then() -> None:
    clock = ManualClock()
    receiver = make(clock)
    with capture_logs() as lines:
        for _ in range(100):
            receiver.publish(BAD)
            clock.advance(0.25)
    assert receiver.counters.dropped_malformed == 100
    assert [line["malformed"] for line in lines] == [1, 41, 81]
    assert {line["event"] for line in lines} == {"mqtt.messages_dropped"}


@pytest.mark.parametrize(
    "frame",
    [Frame(0x36, b"\x00\x01t\x00\x07"), Frame(0x32, b"\x00\x01t\x00\x00"), Frame(0x32, b"\x00\x01t\x00")],
    ids=["qos 3", "identifier 0", "cut identifier"],
)
def test_what_cannot_be_acknowledged_is_only_counted(frame: Frame) -> None:
    receiver = make()
    assert receiver.publish(frame) == b""
    assert receiver.counters.dropped_malformed == 1


async def test_a_full_inbox_is_told() -> None:
    receiver = make(inbox_messages=2)
    with capture_logs() as lines:
        for number in range(5):
            receiver.publish(Frame(0x30, b"\x00\x01t%d" % number))
        receiver.deliver()
    assert [message.payload for message in await receiver.receive()] == [b"3", b"4"]
    assert receiver.counters.received == 5
    assert receiver.counters.dropped_overflow == 3
    assert len(lines) == 1


# -- the inbox, between link and reader -----------------------------------------------------------------------


def message(name: str, qos: int = 0) -> MqttMessage:
    return MqttMessage("t", name.encode(), qos)


def open_inbox(max_messages: int = 3, max_bytes: int = 1000) -> Inbox:
    inbox = Inbox(max_messages, max_bytes)
    inbox.reopen(resumed=False)
    return inbox


def names(messages: list[MqttMessage]) -> list[str]:
    return [message.payload.decode() for message in messages]


async def test_when_full_the_oldest_message_of_qos_0_goes() -> None:
    inbox = open_inbox(3)
    for name in "abcde":
        inbox.put(message(name))
    assert names(await inbox.receive()) == ["c", "d", "e"]
    assert inbox.dropped == 2


async def test_messages_of_qos_1_and_2_are_never_dropped() -> None:
    inbox = open_inbox(2)
    for name, qos in zip("abcdef", (1, 0, 2, 0, 1, 0), strict=True):
        inbox.put(message(name, qos))
    assert names(await inbox.receive()) == ["a", "c", "d", "e", "f"]
    assert inbox.dropped == 1


async def test_bytes_are_bounded_too_but_one_message_always_fits() -> None:
    inbox = open_inbox(100, 10)
    inbox.put(message("12345"))
    inbox.put(message("x" * 50))
    assert names(await inbox.receive()) == ["x" * 50]
    assert inbox.dropped == 1


async def test_the_bounds_start_anew_after_a_take() -> None:
    inbox = open_inbox(2)
    for batch in ("ab", "cd"):
        for name in batch:
            inbox.put(message(name))
        assert names(await inbox.receive()) == list(batch)
    assert inbox.dropped == 0


async def test_a_reader_is_woken_by_the_first_message() -> None:
    inbox = open_inbox()
    got: list[str] = []

    async def read() -> None:
        got.extend(names(await inbox.receive()))

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(read)
        await wait_all_tasks_blocked()
        inbox.put(message("a"))
    assert got == ["a"]


async def test_a_waiting_reader_is_told_when_nothing_more_will_come() -> None:
    inbox = open_inbox()

    async def read() -> None:
        with pytest.raises(LinkError, match="cable"):
            await inbox.receive()

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(read)
        await wait_all_tasks_blocked()
        inbox.end(LinkError("cable"))


async def test_what_is_there_can_be_read_after_the_end() -> None:
    inbox = open_inbox()
    inbox.put(message("a"))
    inbox.end(LinkError("cable"))
    assert names(await inbox.receive()) == ["a"]
    with pytest.raises(LinkError):
        await inbox.receive()


async def test_before_the_first_link_there_is_nothing_to_wait_for() -> None:
    with pytest.raises(LinkError, match="not connected"):
        await Inbox(1, 1).receive()


async def test_a_resumed_session_repeats_qos_1_so_waiting_copies_go() -> None:
    inbox = open_inbox()
    for name, qos in zip("abc", (0, 1, 2), strict=True):
        inbox.put(message(name, qos))
    inbox.reopen(resumed=True)
    assert names(await inbox.receive()) == ["a", "c"]


async def test_a_lost_session_repeats_nothing_so_all_stays() -> None:
    inbox = open_inbox()
    for name, qos in zip("abc", (0, 1, 2), strict=True):
        inbox.put(message(name, qos))
    inbox.reopen(resumed=False)
    assert names(await inbox.receive()) == ["a", "b", "c"]


async def test_a_cancelled_reader_does_not_disturb_the_next() -> None:
    inbox = open_inbox()
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(inbox.receive)
        await wait_all_tasks_blocked()
        tasks.cancel_scope.cancel()
    inbox.put(message("a"))
    assert names(await inbox.receive()) == ["a"]


# -- who owes which acknowledgement ----------------------------------------------------------------------------


def ledger_of_a_link(*, resumed: bool = False) -> DeliveryLedger:
    ledger = DeliveryLedger()
    ledger.begin_link(resumed=resumed)
    return ledger


def arrive(ledger: DeliveryLedger, qos: int, packet_id: int) -> MqttMessage:
    receipt, answer = ledger.admit(qos, packet_id)
    assert receipt is not None
    assert answer == b""
    return MqttMessage("t", b"", qos, receipt=receipt)


def test_a_batch_is_acknowledged_in_order() -> None:
    ledger = ledger_of_a_link()
    batch = [arrive(ledger, 1, 1), MqttMessage("t", b""), arrive(ledger, 2, 2), arrive(ledger, 1, 0x1234)]
    assert ledger.settle(batch) == bytes.fromhex("40 02 00 01  50 02 00 02  40 02 12 34")


def test_qos_1_of_an_earlier_link_is_passed_over() -> None:
    """Its identifier may stand for another message by now."""
    ledger = ledger_of_a_link()
    old = arrive(ledger, 1, 7)
    ledger.begin_link(resumed=True)
    arrive(ledger, 1, 7)
    assert ledger.settle([old]) == b""


def test_qos_2_of_an_earlier_link_counts_within_the_session() -> None:
    ledger = ledger_of_a_link()
    old = arrive(ledger, 2, 7)
    ledger.begin_link(resumed=True)
    assert ledger.admit(2, 7) == (None, b"")
    assert ledger.settle([old]) == b"\x50\x02\x00\x07"


def test_qos_2_of_an_earlier_session_is_passed_over() -> None:
    ledger = ledger_of_a_link()
    old = arrive(ledger, 2, 7)
    ledger.begin_link(resumed=False)
    arrive(ledger, 2, 7)
    assert ledger.settle([old]) == b""


def test_a_repeated_qos_2_is_answered_and_not_delivered() -> None:
    ledger = ledger_of_a_link()
    ledger.settle([arrive(ledger, 2, 7)])
    ledger.begin_link(resumed=True)
    assert ledger.admit(2, 7) == (None, b"\x50\x02\x00\x07")


def test_after_release_the_identifier_is_free_for_another_message() -> None:
    ledger = ledger_of_a_link()
    ledger.settle([arrive(ledger, 2, 7)])
    assert ledger.release(7) == b"\x70\x02\x00\x07"
    arrive(ledger, 2, 7)


def test_qos_2_is_settled_once() -> None:
    ledger = ledger_of_a_link()
    message = arrive(ledger, 2, 7)
    assert ledger.settle([message, message]) == b"\x50\x02\x00\x07"


def test_a_release_of_the_unknown_is_answered() -> None:
    assert ledger_of_a_link().release(9) == b"\x70\x02\x00\x09"


def test_a_message_dropped_for_good_does_not_come_again() -> None:
    ledger = ledger_of_a_link()
    assert ledger.refuse(1, 3) == b"\x40\x02\x00\x03"
    assert ledger.refuse(2, 4) == b"\x50\x02\x00\x04"
    assert ledger.admit(2, 4) == (None, b"\x50\x02\x00\x04")
