"""Retained messages are found by filters, however many there are."""

from __future__ import annotations

import pytest
from tests.mqtt.broker.conftest import owed

from homebot.mqtt.broker.message import BrokerMessage
from homebot.mqtt.broker.retained import RetainedMessages
from homebot.mqtt.topics import topic_matches

TOPICS = ("a", "a/b", "a/b/c", "a//c", "/a", "$SYS/a", "a.b", "+b", "b\n/c")
FILTERS = ("#", "+", "+/+", "a/#", "a/+", "a/+/c", "+/#", "/+", "$SYS/#", "$SYS/+", "a.b", "a", "+/c")


@pytest.mark.parametrize("topic_filter", FILTERS)
@pytest.mark.parametrize("others", [0, 200])
def test_a_filter_finds_the_topics_that_it_matches(topic_filter: str, others: int) -> None:
    retained = RetainedMessages(1000, 1_000_000)
    topics = [*TOPICS, *(f"z/{number}" for number in range(others))]
    for topic in topics:
        assert retained.store(BrokerMessage(topic, b"x"), now=0.0)

    found = [message.topic for message, _ in owed(retained, topic_filter)]

    assert found == [topic for topic in topics if topic_matches(topic_filter, topic)]
