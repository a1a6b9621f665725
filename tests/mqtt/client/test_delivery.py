"""Who owes which acknowledgement."""

from __future__ import annotations

from homebot.mqtt.client.receiver import DeliveryLedger
from homebot.mqtt.message import MqttMessage


def linked(*, resumed: bool = False) -> DeliveryLedger:
    ledger = DeliveryLedger()
    ledger.begin_link(resumed=resumed)
    return ledger


def arrive(ledger: DeliveryLedger, qos: int, packet_id: int) -> MqttMessage:
    receipt, answer = ledger.admit(qos, packet_id)
    assert receipt is not None
    assert answer == b""
    return MqttMessage("t", b"", qos, receipt=receipt)


def test_a_batch_is_acknowledged_in_order() -> None:
    ledger = linked()
    batch = [arrive(ledger, 1, 1), MqttMessage("t", b""), arrive(ledger, 2, 2), arrive(ledger, 1, 0x1234)]
    assert ledger.settle(batch) == bytes.fromhex("40 02 00 01  50 02 00 02  40 02 12 34")


def test_qos_1_of_an_earlier_link_is_passed_over() -> None:
    """Its identifier may stand for another message by now."""
    ledger = linked()
    old = arrive(ledger, 1, 7)
    ledger.begin_link(resumed=True)
    arrive(ledger, 1, 7)
    assert ledger.settle([old]) == b""


def test_qos_2_of_an_earlier_link_counts_within_the_session() -> None:
    ledger = linked()
    old = arrive(ledger, 2, 7)
    ledger.begin_link(resumed=True)
    assert ledger.admit(2, 7) == (None, b"")
    assert ledger.settle([old]) == b"\x50\x02\x00\x07"


def test_qos_2_of_an_earlier_session_is_passed_over() -> None:
    ledger = linked()
    old = arrive(ledger, 2, 7)
    ledger.begin_link(resumed=False)
    arrive(ledger, 2, 7)
    assert ledger.settle([old]) == b""


def test_a_repeated_qos_2_is_answered_and_not_delivered() -> None:
    ledger = linked()
    ledger.settle([arrive(ledger, 2, 7)])
    ledger.begin_link(resumed=True)
    assert ledger.admit(2, 7) == (None, b"\x50\x02\x00\x07")


def test_after_release_the_identifier_is_free_for_another_message() -> None:
    ledger = linked()
    ledger.settle([arrive(ledger, 2, 7)])
    assert ledger.release(7) == b"\x70\x02\x00\x07"
    arrive(ledger, 2, 7)


def test_qos_2_is_settled_once() -> None:
    ledger = linked()
    message = arrive(ledger, 2, 7)
    assert ledger.settle([message, message]) == b"\x50\x02\x00\x07"


def test_a_release_of_the_unknown_is_answered() -> None:
    assert linked().release(9) == b"\x70\x02\x00\x09"


def test_a_message_dropped_for_good_does_not_come_again() -> None:
    ledger = linked()
    assert ledger.refuse(1, 3) == b"\x40\x02\x00\x03"
    assert ledger.refuse(2, 4) == b"\x50\x02\x00\x04"
    assert ledger.admit(2, 4) == (None, b"\x50\x02\x00\x04")
