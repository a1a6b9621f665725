from random import Random

from homebot.gateways.announced.work_budget import BURST, MAX_WAIT, MESSAGE_WORK, RATE, SHARED_BURST, WorkBudgets
from homebot.gateways.mqtt.state_topics import prefix_of

FILTERS = ("hello/+", "homie/5/+/$state", "+/events/rpc")


def spend(offenders: WorkBudgets, topic: str, now: float) -> int:
    """Break rules with short messages until no more are admitted; return how many were."""
    count = 0
    while offenders.admits(offenders.account_for(topic), now):
        offenders.charge(topic, 0, "why", now)
        count += 1
    return count


def accepted(*topics: str, room: int = 1000) -> WorkBudgets:
    offenders = WorkBudgets(prefix_of(FILTERS), room)
    for topic in topics:
        offenders.accept(topic, b"{}", 0.0, is_valid=True)
    return offenders


def test_registered_sources_pay_alone_and_all_others_of_a_prefix_together() -> None:
    offenders = accepted("hello/lamp")
    assert offenders.account_for("hello/lamp") == "hello/lamp"
    assert offenders.account_for("hello/stranger") == "hello/#"
    assert offenders.account_for("homie/5/x/$state") == "homie/#"
    assert offenders.account_for("shelly-1/events/rpc") == offenders.account_for("shelly-2/events/rpc") == "#"


def test_a_stranger_gains_nothing_by_changing_topics() -> None:
    offenders = WorkBudgets(prefix_of(FILTERS))
    admitted = 0
    for number in range(10_000):
        topic = f"hello/{number}"
        if offenders.admits(offenders.account_for(topic), 0.0):
            offenders.charge(topic, 0, "why", 0.0)
            admitted += 1
    assert admitted == SHARED_BURST // MESSAGE_WORK
    assert len(offenders.quarantined()) <= 1


def test_a_flood_elsewhere_takes_nothing_from_registered_devices() -> None:
    offenders = accepted("hello/lamp")
    spend(offenders, "hello/stranger", 0.0)
    assert offenders.admits("hello/lamp", 0.0)
    assert not offenders.admits("hello/#", 0.0)


def test_a_budget_that_is_used_up_is_filled_again_within_a_second_whatever_it_was_spent_on() -> None:
    for length in (0, 1000, 256_000, 32 * 1024 * 1024):
        offenders = accepted("hello/lamp")
        while offenders.admits("hello/lamp", 0.0):
            offenders.charge("hello/lamp", length, "why", 0.0)
        assert offenders.admits("hello/lamp", MAX_WAIT + 0.001)


def test_a_valid_announcement_clears_the_charge_of_its_topic_once_in_a_second() -> None:
    offenders = accepted("hello/lamp")
    assert spend(offenders, "hello/lamp", 0.0) == BURST // MESSAGE_WORK
    offenders.accept("hello/lamp", b"{}", 0.0, is_valid=True)
    assert spend(offenders, "hello/lamp", 0.0) == BURST // MESSAGE_WORK
    offenders.accept("hello/lamp", b"{}", 0.1, is_valid=True)
    assert spend(offenders, "hello/lamp", 0.1) < BURST // MESSAGE_WORK / 2


def test_the_topics_of_many_devices_share_one_budget_as_well() -> None:
    topics = [f"hello/{number}" for number in range(3000)]
    offenders = accepted(*topics, room=100)
    for now in range(10):
        for topic in topics:
            if offenders.admits(topic, float(now)):
                offenders.charge(topic, 0, "why", float(now))
    assert offenders.work <= 8 * BURST + 10 * 4 * RATE + 3000 * MESSAGE_WORK
    assert offenders.forgotten > 0


def test_a_device_that_never_broke_a_rule_does_not_wait_for_those_that_do() -> None:
    offenders = accepted("hello/honest", *(f"hello/{number}" for number in range(100)))
    for number in range(100):
        spend(offenders, f"hello/{number}", 0.0)
    assert offenders.admits("hello/honest", 0.0)


def test_payloads_like_the_accepted_announcement_are_recognized() -> None:
    offenders = WorkBudgets(prefix_of(FILTERS))
    offenders.accept("hello/list", b'[{"ieee_address": "0x1", "type": "Router"}]', 0.0, is_valid=True)
    assert offenders.resembles("hello/list", b'[{"ieee_address": "0x1"}, {"ieee_address": "0x2"}]')
    assert not offenders.resembles("hello/list", b'[{"ieee_address": "0x1"')
    assert not offenders.resembles("hello/list", b"garbage")
    assert not offenders.resembles("hello/other", b"[]")


def test_the_work_is_bounded_in_any_order_of_messages() -> None:
    """Over random floods: what one topic and one prefix cost in a second, valid announcements among it or not."""
    for seed in range(30):
        random = Random(seed)  # noqa: S311 - the same run each time
        offenders = accepted("hello/lamp")
        now, longest = 0.0, 0
        while now < 20.0:
            now += random.choice((0.0, 0.0, 0.0, 0.001, 0.05, random.random()))
            topic = random.choice(("hello/lamp", f"hello/{random.randrange(1000)}"))
            if not offenders.admits(offenders.account_for(topic), now):
                continue
            if random.random() < 0.1:
                offenders.accept("hello/lamp", b"{}", now, is_valid=True)
                continue
            length = random.choice((0, 100, 10_000, 300_000))
            longest = max(longest, length)
            offenders.charge(topic, length, "why", now)
        over = 2 * 21 * (MESSAGE_WORK + longest)
        assert offenders.work <= 21 * (BURST + RATE) + SHARED_BURST + 21 * RATE + over
