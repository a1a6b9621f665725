"""The light service: it answers on with off, notes off once, and nothing a lamp says ends it; in virtual time."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from structlog.testing import capture_logs
from tests.thesis_light_service import ThesisLightService

from homebot.apps import NoSettings
from homebot.discovery import Directory, DirectorySettings
from homebot.graph import Graph, Node
from homebot.testing import FakeGateway, FakeGatewaySettings

pytestmark = pytest.mark.virtual_time


@asynccontextmanager
async def light_service(graph: Graph | None = None, **settings: object) -> AsyncIterator[FakeGateway]:
    """A gateway to lamps, a directory, and the light service."""
    graph = graph or Graph()
    async with (
        Node(graph, "fake", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as discovery,
        Node(graph, "light_service") as node,
        anyio.create_task_group() as tasks,
    ):
        gateway = FakeGateway(gateway_node, FakeGatewaySettings.model_validate(settings))
        await tasks.start(Directory(discovery, DirectorySettings()).serve)
        await tasks.start(ThesisLightService(node, NoSettings()).serve)
        yield gateway
        await anyio.sleep(0.01)
        tasks.cancel_scope.cancel()


async def settle() -> None:
    await anyio.sleep(0.01)


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("0.6", ["off"]),
        ("1", ["off"]),
        ("0.01", ["off"]),
        ("0", []),
        ("2700 K", []),
    ],
)
async def test_a_lamp_is_judged_by_its_value(word: str, told: list[str]) -> None:
    with capture_logs() as lines:
        async with light_service() as gateway:
            for _ in range(3):
                await gateway.says("lights/a", word)
                await settle()
    assert gateway.told == [("lights/a/in", one) for one in told * 3]
    assert [line["event"] for line in lines if line["event"].startswith("light_service")] == (
        ["light_service.turned_off"] * 3 if told else ["light_service.is_off"] if word == "0" else []
    )


async def test_off_is_noted_once_until_the_lamp_was_on_again() -> None:
    with capture_logs() as lines:
        async with light_service() as gateway:
            for word in ("off", "off", "on", "off", "off"):
                await gateway.says("lights/a", word)
                await settle()
    said = [line["message"] for line in lines if line["event"].startswith("light_service")]
    assert said == ["lights/a is off", "lights/a is on: turned it off", "lights/a is off"]


@pytest.mark.parametrize(
    ("payload", "problem"),
    [(b"\xff\xfe", "the payload on lights/a/out is not text"), (b"dimmed", "lights/a/out reported neither on nor off")],
)
async def test_what_it_does_not_understand_is_told_once_and_it_goes_on(payload: bytes, problem: str) -> None:
    """A flood of it is a line in ten seconds, with the number of those held back."""
    with capture_logs() as lines:
        async with light_service() as gateway:
            await gateway.says("lights/a", payload)
            await settle()
            for _ in range(99):
                await gateway.says("lights/a", payload)
            await anyio.sleep(10)
            await gateway.says("lights/a", payload)
            await gateway.says("lights/a", "on")
    told = [line["message"] for line in lines if line["event"] == "light_service.not_understood"]
    assert len(told) == 2
    assert told[0].startswith(f"lights/a: {problem}")
    assert told[1].endswith("(and 99 more like this)")
    assert gateway.told == [("lights/a/in", "off")]


async def test_a_lamp_that_is_removed_and_back_is_answered_once() -> None:
    with capture_logs() as lines:
        async with light_service() as gateway:
            await gateway.says("lights/a", "off")
            await settle()
            gateway.removes("lights/a")
            await settle()
            await gateway.says("lights/a", "off")
            await settle()
            await gateway.says("lights/a", "on")
    assert [line["event"] for line in lines if line["event"].startswith("light_service")] == [
        "light_service.is_off",
        "light_service.is_off",
        "light_service.turned_off",
    ]
    assert gateway.told == [("lights/a/in", "off")]


async def test_a_lamp_that_is_described_anew_is_not_answered_for_old_words() -> None:
    """A change is no reason to hear everything again."""
    async with light_service() as gateway:
        await gateway.says("lights/a", "on")
        await settle()
        await gateway.says("lights/a", "off", name="reading lamp")
    assert gateway.told == [("lights/a/in", "off")]


async def test_a_lamp_that_takes_no_commands_is_told_about_and_the_others_are_served() -> None:
    """It can say on as long as it likes."""
    with capture_logs() as lines:
        async with light_service() as gateway:
            await gateway.says("lights/deaf", "on", takes_commands=False)
            await gateway.says("lights/deaf", "on", takes_commands=False)
            await gateway.says("lights/a", "on")
    told = [line["message"] for line in lines if line["event"] == "light_service.not_turned_off"]
    assert told == ["lights/deaf: a command to lights/deaf was refused: it takes no commands"]
    assert gateway.told == [("lights/a/in", "off")]


async def test_a_lamp_that_may_not_be_listened_to_is_told_about() -> None:
    with capture_logs() as lines:
        async with light_service(refused=("lights/a/out",)) as gateway:
            await gateway.says("lights/a", "on")
            await gateway.says("lights/b", "on")
    told = [line["message"] for line in lines if line["event"] == "light_service.no_messages"]
    assert told == ["lights/a: listening to lights/a/out was refused: the test refuses it"]
    assert gateway.told == [("lights/b/in", "off")]


async def test_lamps_that_flicker_do_not_flood_the_log() -> None:
    """Each is answered every time, and told about five times in ten seconds."""
    with capture_logs() as lines:
        async with light_service() as gateway:
            await gateway.says("lights/a", "on")
            await settle()
            for _ in range(99):
                await gateway.says("lights/a", "on")
    assert len(gateway.told) == 100
    assert len([line for line in lines if line["event"] == "light_service.turned_off"]) == 5
