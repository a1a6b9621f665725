"""The suite of the gateway contract says which step failed, what it waited for, and what came instead."""

import re
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
import pytest
from tests.gateways import test_contract_memory as memory

from homebot.devices.value import PlainValue
from homebot.testing.gateway_contract import Lamp
from homebot.testing.gateway_contract.world import GatewayWorld

pytestmark = pytest.mark.virtual_time

PATIENCE = "within 20 s"


class Unseen(memory.MemoryLamp):
    async def announce(self) -> None: ...


class Silent(memory.MemoryLamp):
    async def report(self, *, on: bool) -> None: ...


class Stuck(memory.MemoryLamp):
    async def report(self, *, on: bool) -> None:
        await super().report(on=on and False)


class Deaf(memory.MemoryLamp):
    async def told(self) -> bool | None:
        return None

    async def told_value(self, capability: str) -> PlainValue:
        del capability
        return 5.0


class Staying(memory.MemoryLamp):
    async def withdraw(self) -> None: ...


class Polite(memory.MemoryLamp):
    async def misbehave(self) -> None: ...


class Linked(memory.MemoryLamp):
    async def mend_link(self) -> None: ...


class OtherWords(memory.MemoryLamp):
    async def report(self, *, on: bool) -> None:
        await self.gateway.receive(self.key, self.raw(on=on) + b" ")


Suite = memory.TestMemoryGateway
Step = Callable[[memory.TestMemoryGateway], Coroutine[Any, Any, None]]

FAILURES: list[tuple[type[memory.MemoryLamp], Step, str]] = [
    (
        Unseen,
        Suite.test_a_command_reaches_the_device,
        "a sighting of the lamp after Lamp.announce(), by PublishedDevices.put, did not come on "
        f"/gateway/gateway/received_topics {PATIENCE}; the last that came:\n  nothing",
    ),
    (
        Silent,
        Suite.test_a_command_reaches_the_device,
        "a report of hall that on_off is False, by PublishedDevices.report, did not come on /gateway/gateway/readings",
    ),
    (
        Stuck,
        Suite.test_a_report_has_the_values_of_the_vocabulary,
        f"on_off is True, by PublishedDevices.report, did not come on /gateway/gateway/readings {PATIENCE}; "
        "the last that came:\n  Report(gateway='gateway', key='hall'",
    ),
    (
        Deaf,
        Suite.test_a_command_reaches_the_device,
        f"Lamp.told() did not return True {PATIENCE}; it returned None",
    ),
    (
        Deaf,
        Suite.test_the_suite_sets_every_capability_that_the_part_takes_and_it_reaches_the_device,
        f"Lamp.told_value('level') did not return 40.0 {PATIENCE}; it returned 5.0",
    ),
    (
        Staying,
        Suite.test_a_device_that_is_gone_is_removed_and_late_joiners_hear_nothing_of_it,
        "after Lamp.withdraw() a sighting of the kind `removed`, by PublishedDevices.remove, did not come on",
    ),
    (
        Polite,
        Suite.test_a_peer_that_breaks_the_rules_is_quarantined_and_the_others_are_read,
        "after Lamp.misbehave() a quarantine, by `admits` and `reject`, did not come on /gateway/gateway/quarantine",
    ),
    (
        Linked,
        Suite.test_without_its_link_it_is_unavailable_keeps_its_devices_and_comes_back,
        "the state `active`, by publish_state, did not come on /gateway/gateway/state",
    ),
    (
        Linked,
        Suite.test_without_its_link_its_devices_are_unreachable_until_it_comes_back,
        "the lamp as reachable did not come on /discovery/changes",
    ),
]


@pytest.mark.parametrize(("kind", "step", "problem"), FAILURES, ids=[f"{one[0].__name__}" for one in FAILURES])
async def test_a_failed_step_names_what_did_not_come_and_what_did(
    kind: type[memory.MemoryLamp], step: Step, problem: str
) -> None:
    """It waited for a minute, and ended with a TimeoutError without a word."""

    class Suited(memory.TestMemoryGateway):
        __test__ = False

        @asynccontextmanager
        async def lamp(self) -> AsyncIterator[Lamp]:
            yield kind("hall", address="memory/hall")

    began = anyio.current_time()
    with pytest.raises(AssertionError) as caught:
        await step(Suited())
    assert problem in re.sub(r"\s+\n", "\n", str(caught.value))
    assert anyio.current_time() - began < 30


async def test_a_raw_message_in_other_words_is_named() -> None:
    class Suited(memory.TestMemoryGateway):
        __test__ = False

        @asynccontextmanager
        async def lamp(self) -> AsyncIterator[Lamp]:
            yield OtherWords("hall", address="memory/hall")

    test = Suited().test_raw_messages_come_to_the_inbox_of_who_asks_or_to_the_topic_of_the_device
    lamp_says = r"after Lamp\.report\(\) the message Lamp\.raw\(\), by PublishedDevices\.deliver_raw, did not come on"
    with pytest.raises(AssertionError, match=lamp_says):
        await test("inbox")


def test_the_guide_has_what_an_author_writes() -> None:
    guide = (Path(__file__).parents[2] / "docs" / "gateways.md").read_text("utf-8")
    methods = {name for name, one in vars(Lamp).items() if callable(one) and not name.startswith("_")}
    assert {name for name in methods if f"`{name}(" not in guide} == set()
    settings = {name for name in vars(GatewayWorld) if name.startswith(("takes_", "tells_", "time_"))}
    assert {name for name in settings if name not in guide} == set()
