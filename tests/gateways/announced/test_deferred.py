from homebot.gateways.announced.quarantine import MAX_WORK_EACH, DeferredMessages
from homebot.gateways.announced.work_budget import MESSAGE_WORK
from homebot.mqtt.message import MqttMessage


def message(topic: str, number: int, length: int = 10) -> MqttMessage:
    return MqttMessage(topic, f"{number}".encode().ljust(length))


def add(deferred: DeferredMessages[MqttMessage], one: MqttMessage, payer: str, *, is_like: bool) -> None:
    deferred.add(one, one.topic, len(one.payload), payer, is_like=is_like)


def numbers(deferred: DeferredMessages[MqttMessage], *payers: str) -> list[tuple[str, int]]:
    """What is taken for *payers*, by topic and number."""
    return [(one.topic, int(one.payload)) for one in deferred.release(lambda payer: payer in payers)]


def test_messages_of_a_topic_are_taken_in_their_order_once_their_payer_may() -> None:
    deferred: DeferredMessages[MqttMessage] = DeferredMessages()
    for number in range(3):
        add(deferred, message("a", number), "a", is_like=False)
    assert "a" in deferred.sources
    assert numbers(deferred, "b") == []
    assert numbers(deferred, "a") == [("a", 0), ("a", 1), ("a", 2)]
    assert not deferred.sources
    assert deferred.account.used == 0


def test_the_newest_topic_of_a_prefix_comes_first_and_each_payer_in_turn() -> None:
    deferred: DeferredMessages[MqttMessage] = DeferredMessages()
    for topic in ("x/1", "x/2"):
        add(deferred, message(topic, 1), "x/#", is_like=False)
    add(deferred, message("own", 1), "own", is_like=True)
    assert numbers(deferred, "x/#", "own") == [("x/2", 1), ("own", 1), ("x/1", 1)]


def test_of_too_many_on_a_topic_those_go_first_that_look_like_nothing_known() -> None:
    deferred: DeferredMessages[MqttMessage] = DeferredMessages()
    add(deferred, message("a", 0), "a", is_like=True)
    most = MAX_WORK_EACH // (MESSAGE_WORK + 10)
    for number in range(1, 1001):
        add(deferred, message("a", number), "a", is_like=False)
    left = numbers(deferred, "a")
    assert left[0] == ("a", 0)
    assert [number for _, number in left[1:]] == list(range(1001 - most + 1, 1001))
    assert deferred.dropped == 1001 - most


def test_one_that_is_longer_than_all_that_may_wait_on_a_topic_waits_alone() -> None:
    deferred: DeferredMessages[MqttMessage] = DeferredMessages()
    add(deferred, message("a", 0), "a", is_like=False)
    add(deferred, message("a", 1, length=MAX_WORK_EACH), "a", is_like=True)
    add(deferred, message("a", 2), "a", is_like=False)
    assert numbers(deferred, "a") == [("a", 1)]


def test_a_withdrawn_announcement_waits_no_more() -> None:
    deferred: DeferredMessages[MqttMessage] = DeferredMessages()
    add(deferred, message("a", 0), "a", is_like=False)
    deferred.drop("a")
    deferred.drop("a")
    assert "a" not in deferred.sources
    assert deferred.account.used == 0


def test_a_flood_of_topics_is_bounded_and_costs_those_without_devices_first() -> None:
    deferred: DeferredMessages[MqttMessage] = DeferredMessages(max_bytes=100_000)
    add(deferred, message("own", 0), "own", is_like=True)
    for number in range(10_000):
        add(deferred, message(f"x/{number}", number), "x/#", is_like=False)
        assert deferred.account.used <= 100_000
    left = numbers(deferred, "own", "x/#")
    assert left[0] == ("own", 0)
    assert left[1] == ("x/9999", 9999)
    assert deferred.dropped == 10_001 - len(left)
