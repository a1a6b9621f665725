"""Random commands to devices that behave at random: every command has a complete chain in the journal."""

from collections.abc import Sequence
from functools import partial
from itertools import groupby
from random import Random

import anyio
import pytest
from tests.control.conftest import Behaviour, Home, ignore, obey, obey_after, report

from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.outcomes import Outcome
from homebot.errors import LinkError

pytestmark = pytest.mark.virtual_time

LAMPS = 8  # so many that the journal folds no command: it keeps ten a minute of each in full
COMMANDS = 40


def behaviour(random: Random) -> Behaviour:
    """One of the ways of devices: honest, slow, deaf, stuck, going back, or lost in the network."""
    delay = random.uniform(0.05, 12.0)
    return random.choice(
        [
            obey,
            obey_after(delay),
            ignore,
            report((delay, False)),
            report((delay, True), (delay + 3.0, False)),
            report((delay, True), (delay + 0.1, False), (delay + 0.2, True)),
            unreachable,
        ]
    )


async def unreachable(home: Home, command: Command) -> None:
    """Fail as a gateway does that lost its network for a moment."""
    raise LinkError("the cable is out")


@pytest.mark.parametrize("seed", range(10))
async def test_every_command_has_a_complete_chain(home: Home, seed: int) -> None:
    random = Random(seed)  # noqa: S311
    for number in range(LAMPS):
        home.put(f"lamp{number}", "light", "on_off", is_silent=random.random() < 0.2)
    await home.handle(Light, "lamp0")
    lamps = await home.devices.find(Light)
    outcomes: list[Outcome] = []

    async def command(lamp: Light, *, on: bool) -> None:
        outcomes.append(await (lamp.turn_on() if on else lamp.turn_off()))

    async with anyio.create_task_group() as tasks:
        for _ in range(COMMANDS):
            lamp = random.choice(lamps)
            home.behaviours[lamp.name.lower()] = behaviour(random)
            tasks.start_soon(partial(command, lamp, on=random.random() < 0.6))
            await anyio.sleep(random.expovariate(0.5))
    await anyio.sleep(60)
    found = await home.read()
    assert found.complete
    chains = by_command(found.entries)
    assert set(chains) == {one.command_id for one in outcomes}
    for outcome in outcomes:
        check(chains[outcome.command_id], outcome, set(chains))


def by_command(entries: Sequence[JournalEntry]) -> dict[str, list[JournalEntry]]:
    ordered = sorted((one for one in entries if one.command), key=lambda one: one.command)
    return {name: list(chain) for name, chain in groupby(ordered, key=lambda one: one.command)}


def check(chain: Sequence[JournalEntry], outcome: Outcome, commands: set[str]) -> None:
    """The chain begins with the request, has the one outcome that the app got, and between them what explains it."""
    kinds = [one.kind for one in chain]
    assert kinds[0] == "requested"
    assert kinds.count("outcome") == 1
    assert [one.at.to_seconds() for one in chain] == sorted(one.at.to_seconds() for one in chain)
    decided = chain[kinds.index("outcome")].results[0]
    assert (decided.command_id, decided.text) == (outcome.command_id, outcome.text)
    late = {"reported"} if decided.outcome in {"no_answer", "contradicted"} else set()
    assert set(kinds[kinds.index("outcome") + 1 :]) <= {"reverted"} | late
    assert 0 <= kinds.count("sent") - kinds.count("acknowledged") <= 1
    match decided.outcome:
        case "confirmed":
            assert "acknowledged" in kinds
            assert ("reported" in kinds) is (decided.evidence >= 3)
        case "contradicted":
            assert "reported" in kinds
        case "superseded":
            assert decided.by in commands
        case "no_answer":
            assert "sent" in kinds
        case "already_so":
            assert "reverted" not in kinds
        case _:
            raise AssertionError(decided)
