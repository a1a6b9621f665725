"""Things to do later."""

import pytest

from homebot.mqtt.broker.deadlines import BrokerTimers


def test_what_is_due_is_done_once_in_order_of_time() -> None:
    done: list[str] = []
    deadlines = BrokerTimers()
    deadlines.at(2.0, lambda: done.append("second"))
    deadlines.at(1.0, lambda: done.append("first"))
    deadlines.at(3.0, lambda: done.append("third"))
    deadlines.run(2.0)
    deadlines.run(2.0)
    assert done == ["first", "second"]
    assert deadlines.earliest == 3.0


def test_a_cancelled_deadline_is_not_done_and_not_waited_for() -> None:
    done: list[int] = []
    deadlines = BrokerTimers()
    deadline = deadlines.at(1.0, lambda: done.append(1))
    deadline.cancel()
    assert deadlines.earliest is None
    deadlines.run(5.0)
    assert done == []


def test_cancelled_deadlines_do_not_pile_up() -> None:
    deadlines = BrokerTimers()
    kept = [deadlines.at(float(number), lambda: None) for number in range(10)]
    for number in range(5000):
        deadlines.at(1e6 + number, lambda: None).cancel()
    assert len(deadlines._queue._heap) < 200
    assert deadlines.earliest == kept[0].when


def test_the_owner_is_woken_for_an_earlier_deadline_only() -> None:
    woken: list[float] = []
    deadlines = BrokerTimers(woken.append)
    for when in (5.0, 7.0, 3.0, 4.0):
        deadlines.at(when, lambda: None)
    assert woken == [5.0, 3.0]


def test_what_is_noted_while_others_run_waits_for_the_next_run() -> None:
    """Or work that goes on in slices would leave nobody a turn between them."""
    deadlines = BrokerTimers()
    ran: list[int] = []

    def again() -> None:
        ran.append(len(ran))
        deadlines.at(0.0, again)

    deadlines.at(0.0, again)
    deadlines.run(1.0)
    assert ran == [0]
    deadlines.run(1.0)
    assert ran == [0, 1]


def test_a_failure_costs_none_of_the_others() -> None:
    deadlines = BrokerTimers()
    ran: list[str] = []

    def fail() -> None:
        raise ValueError("broken")

    deadlines.at(0.0, fail)
    deadlines.at(0.0, lambda: ran.append("other"))
    with pytest.raises(ValueError, match="broken"):
        deadlines.run(1.0)
    deadlines.run(1.0)
    assert ran == ["other"]
