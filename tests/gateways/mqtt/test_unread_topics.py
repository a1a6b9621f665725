"""Topics that nothing here reads are told by their first levels, so that programs that do not announce show."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from random import Random

import anyio
import pytest

from homebot.gateways.mqtt.unread_topics import unread_notes
from homebot.mqtt.client import MqttClient
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions, MqttProtocol
from homebot.mqtt.packets import ReasonCode
from homebot.mqtt.topic_census import LISTENS_EVERY, LISTENS_FOR, TopicCensus

pytestmark = pytest.mark.virtual_time

USED = ("dev/a/state", "plug/set", "+/5/+/$state")


@asynccontextmanager
async def looking(protocol: MqttProtocol = "auto", **limits: int) -> AsyncIterator[tuple[TopicCensus, MqttClient]]:
    """Listen on a broker with retained messages; a program publishes there."""
    async with MemoryBroker(random=Random(1)) as broker, anyio.create_task_group() as tasks:  # noqa: S311 - the same run each time
        options = MqttOptions.from_url(broker.url, protocol=protocol, client_id="homebot")
        census = TopicCensus(broker.make_client, options, **limits)
        program = broker.make_client(MqttOptions.from_url(broker.url, client_id="program"))
        async with program.connected():
            for number in range(50):
                await program.publish(f"old/{number}", b"kept", qos=1, retain=True)
            tasks.start_soon(census.serve)
            await anyio.sleep(1)
            yield census, program
        tasks.cancel_scope.cancel()


def notes(census: TopicCensus) -> list[str]:
    return list(unread_notes(census.counts, USED.__contains__, USED, ("zigbee2mqtt/bridge/devices", "+/+/$homie")))


async def publish(program: MqttClient, *topics: str, times: int = 5, payload: bytes = b"x") -> None:
    for topic in topics * times:
        await program.publish(topic, payload, qos=1)
    await anyio.sleep(1)


async def test_busy_topics_that_nothing_reads_are_counted_by_their_first_levels() -> None:
    async with looking() as (census, program):
        await publish(program, "frigate/cam/person", "frigate/stats", "alone")
        (note,) = notes(census)
        assert note.startswith("nothing here reads the topics that begin with frigate (10), alone (5), counted for ")


@pytest.mark.parametrize(
    "topic",
    [
        "dev/a/state",
        "dev/a/other",  # of a known device
        "plug/set",  # a command
        "zigbee2mqtt/bridge/logging",  # of a program that announces
        "homebot/computer/mqtt/status",
        "old/1",  # retained, and perhaps years old
    ],
)
async def test_what_is_known_is_not_told(topic: str) -> None:
    async with looking() as (census, program):
        if not topic.startswith("old"):
            await publish(program, topic)
        assert notes(census) == []


async def test_beside_a_known_device_the_second_level_is_told() -> None:
    async with looking() as (census, program):
        await publish(program, "dev/b/state", "dev/b/more")
        (note,) = notes(census)
        assert "dev/b (10)," in note


async def test_a_topic_whose_convention_knows_it_is_told_by_the_setting_that_reads_it_however_rare() -> None:
    async with looking() as (census, program):
        await publish(program, "fleet/v3/kit/1/state", times=1)
        await publish(program, "frigate/stats")

        def hint(topic: str) -> str:
            return "set interfaces" if topic.startswith("fleet/") else ""

        hinted, busy = unread_notes(census.counts, USED.__contains__, USED, (), [hint])
        assert (hinted, "fleet" in busy, "frigate (5)" in busy) == ("set interfaces", False, True)


async def test_few_messages_and_pictures_are_left_out() -> None:
    async with looking() as (census, program):
        await publish(program, "rare/x", times=2)
        await publish(program, "picture/x", payload=b"x" * 100_000)
        assert notes(census) == []


async def test_a_look_lasts_a_minute_and_is_taken_again_after_an_hour() -> None:
    async with looking() as (census, program):
        await publish(program, "early/x")
        await anyio.sleep(LISTENS_FOR)
        await publish(program, "late/x")
        assert [("early" in one, "late" in one) for one in notes(census)] == [(True, False)]
        await anyio.sleep(LISTENS_EVERY)
        await publish(program, "late/x")
        assert [("early" in one, "late" in one) for one in notes(census)] == [(False, True)]


async def test_a_look_that_is_ended_hides_no_missing_subscriber_and_keeps_its_counts() -> None:
    async with looking() as (census, program):
        await publish(program, "early/x")
        assert await program.publish("plug/set", b"on", qos=1) != ReasonCode.NO_MATCHING_SUBSCRIBERS
        await census.end()
        assert await program.publish("plug/set", b"on", qos=1) == ReasonCode.NO_MATCHING_SUBSCRIBERS
        assert [("early" in one) for one in notes(census)] == [True]


async def test_a_flood_ends_a_look_and_names_few() -> None:
    async with looking(most_messages=60, most_topics=10) as (census, program):
        await publish(program, *(f"p{number}/x" for number in range(20)), times=3)
        await publish(program, *(f"p{number}/x" for number in range(20)), times=10)
        (note,) = notes(census)
        assert note.count("(") - note.count("(docs") == 5
        assert " and 5 more," in note


async def test_a_broker_that_would_send_all_retained_messages_is_not_listened_to() -> None:
    async with looking("3.1.1") as (census, program):
        await publish(program, "frigate/cam/person")
        assert notes(census) == []
