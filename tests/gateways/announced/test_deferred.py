from homebot.gateways.announced.quarantine import DeferredMessages
from homebot.mqtt.message import MqttMessage


def message(topic: str, number: int) -> MqttMessage:
    return MqttMessage(topic, f"{number}".encode())


def add(deferred: DeferredMessages[MqttMessage], one: MqttMessage, payer: str) -> None:
    deferred.add(one, one.topic, len(one.payload), payer)


def numbers(deferred: DeferredMessages[MqttMessage], *payers: str) -> list[tuple[str, int]]:
    """What is taken for *payers*, by topic and number."""
    return [(one.topic, int(one.payload)) for one in deferred.release(lambda payer: payer in payers)]


def test_the_newest_message_of_a_topic_waits_until_its_payer_may() -> None:
    deferred: DeferredMessages[MqttMessage] = DeferredMessages()
    for number in range(3):
        add(deferred, message("a", number), "a")
    assert "a" in deferred.sources
    assert numbers(deferred, "b") == []
    assert numbers(deferred, "a") == [("a", 2)]
    assert deferred.dropped == 2
    assert not deferred.sources
    assert deferred.account.used == 0


def test_the_newest_topic_of_a_prefix_comes_first_and_each_payer_in_turn() -> None:
    deferred: DeferredMessages[MqttMessage] = DeferredMessages()
    for topic in ("x/1", "x/2"):
        add(deferred, message(topic, 1), "x/#")
    add(deferred, message("own", 1), "own")
    assert numbers(deferred, "x/#", "own") == [("x/2", 1), ("own", 1), ("x/1", 1)]


def test_a_withdrawn_announcement_waits_no_more() -> None:
    deferred: DeferredMessages[MqttMessage] = DeferredMessages()
    add(deferred, message("a", 0), "a")
    deferred.drop("a")
    deferred.drop("a")
    assert "a" not in deferred.sources
    assert deferred.account.used == 0


def test_a_flood_of_topics_is_bounded_and_costs_those_without_devices_first() -> None:
    deferred: DeferredMessages[MqttMessage] = DeferredMessages(max_bytes=100_000)
    add(deferred, message("own", 0), "own")
    for number in range(10_000):
        add(deferred, message(f"x/{number}", number), "x/#")
        assert deferred.account.used <= 100_000
    left = numbers(deferred, "own", "x/#")
    assert left[0] == ("own", 0)
    assert left[1] == ("x/9999", 9999)
    assert deferred.dropped == 10_001 - len(left)
