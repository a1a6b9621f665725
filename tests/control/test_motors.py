"""Outcomes of what has a motor: how it tells that it is on its way, and how long it takes; in virtual time."""

from collections.abc import Mapping
from typing import TypeAlias

import anyio
import pytest
from tests.control.conftest import Behaviour, Home, OpenHome, ignore

from homebot.devices.gateway_messages import Command
from homebot.devices.handles import WindowCovering
from homebot.devices.outcomes import AlreadySo, Confirmed, Contradicted, NoAnswer, Outcome
from homebot.devices.value import PlainValue

pytestmark = pytest.mark.virtual_time

Step: TypeAlias = tuple[float, Mapping[str, PlainValue]]


def on_the_way(*steps: Step) -> Behaviour:
    """Report the values of each step so many seconds after a command; a repetition changes nothing."""

    async def behaviour(home: Home, command: Command) -> None:
        if len(home.commands) > 1:
            return
        for seconds, values in steps:
            home.tasks.start_soon(tell, home, command.key, seconds, values)

    async def tell(home: Home, key: str, seconds: float, values: Mapping[str, PlainValue]) -> None:
        await anyio.sleep(seconds)
        await home.gateway.devices.report(key, values)

    return behaviour


async def commanded(open_home: OpenHome, setting: tuple[str, PlainValue], *steps: Step) -> tuple[Outcome, int]:
    """Command an open blind, and return what became of it, and how often it was sent."""
    async with open_home() as home:
        blind = await home.new(WindowCovering, "blind", "movement", "position")
        await home.gateway.devices.report("blind", {"movement": "open", "position": 100.0})
        await anyio.sleep(1)
        home.behaviours["blind"] = on_the_way(*steps) if steps else ignore
        return await blind.command(*setting), len(home.commands)


STATE_FOLLOWS_POSITION: list[Step] = [
    (3.0 * step, {"movement": "open" if step < 10 else "closed", "position": 100.0 - 10 * step})
    for step in range(1, 11)
]
"""A Zigbee blind in Zigbee2MQTT, such as IKEA Fyrtur: it is open until it is closed."""


async def test_a_blind_that_is_open_until_it_is_closed_is_known_to_move_by_its_position(open_home: OpenHome) -> None:
    outcome, sendings = await commanded(open_home, ("movement", "closed"), *STATE_FOLLOWS_POSITION)
    assert isinstance(outcome, Confirmed)
    assert (round(outcome.latency), sendings) == (30, 1)


async def test_a_blind_that_tells_its_position_at_the_end_is_known_to_move_by_its_words(open_home: OpenHome) -> None:
    outcome, sendings = await commanded(
        open_home, ("position", 40.0), (0.1, {"movement": "closing"}), (25.0, {"movement": "open", "position": 40.0})
    )
    assert isinstance(outcome, Confirmed)
    assert (round(outcome.latency), sendings) == (25, 1)


@pytest.mark.parametrize("old", [[], [(0.1, {"movement": "open", "position": 100.0})]])
async def test_a_blind_that_tells_nothing_new_until_it_is_closed_is_no_false_alarm(
    open_home: OpenHome, old: list[Step]
) -> None:
    """Some report once more how they are when they begin, such as Tuya TS130F."""
    closed: Step = (25.0, {"movement": "closed", "position": 0.0})
    outcome, sendings = await commanded(open_home, ("movement", "closed"), *old, closed)
    assert isinstance(outcome, Confirmed)
    assert (round(outcome.latency), sendings) == (25, 1)


async def test_a_blind_that_gets_stuck_on_its_way_is_contradicted(open_home: OpenHome) -> None:
    outcome, _ = await commanded(open_home, ("movement", "closed"), *STATE_FOLLOWS_POSITION[:3])
    assert isinstance(outcome, Contradicted)
    assert outcome.saw == "movement is open"


OBSTRUCTED: list[Step] = [(0.1, {"movement": "closing"}), (3.0, {"movement": "stopped", "position": 62.0})]
"""As Shelly's covers report an obstacle, or that somebody stopped them at the wall."""


@pytest.mark.parametrize(
    ("setting", "saw"), [(("movement", "closed"), "movement is stopped"), (("position", 20.0), "position is 62")]
)
async def test_a_blind_that_stopped_on_its_way_is_contradicted_without_a_minute(
    open_home: OpenHome, setting: tuple[str, PlainValue], saw: str
) -> None:
    began = anyio.current_time()
    outcome, sendings = await commanded(open_home, setting, *OBSTRUCTED)
    assert isinstance(outcome, Contradicted)
    assert (outcome.saw, sendings, round(anyio.current_time() - began)) == (saw, 1, 14)


async def test_a_blind_that_goes_on_after_it_stopped_is_waited_for(open_home: OpenHome) -> None:
    goes_on: list[Step] = [(9.0, {"movement": "closing"}), (40.0, {"movement": "closed", "position": 0.0})]
    outcome, sendings = await commanded(open_home, ("movement", "closed"), *OBSTRUCTED, *goes_on)
    assert isinstance(outcome, Confirmed)
    assert (round(outcome.latency), sendings) == (40, 1)


async def test_a_blind_that_tells_where_it_stopped_later_is_waited_for(open_home: OpenHome) -> None:
    moves: list[Step] = [(0.1, {"movement": "closing"}), (20.0, {"movement": "stopped"}), (26.0, {"position": 20.0})]
    outcome, _ = await commanded(open_home, ("position", 20.0), *moves)
    assert isinstance(outcome, Confirmed)
    assert round(outcome.latency) == 26


async def test_a_blind_that_never_reports_has_a_minute(open_home: OpenHome) -> None:
    outcome, sendings = await commanded(open_home, ("movement", "closed"))
    assert isinstance(outcome, NoAnswer)
    assert (round(outcome.waited), sendings) == (60, 1)


async def test_a_blind_that_is_known_to_be_away_has_ten_seconds(home: Home) -> None:
    home.put("blind", "window_covering", "movement", "position")
    home.behaviours["blind"] = ignore
    home.gateway.devices.report_reachable("blind", reachable=False)
    outcome = await (await home.handle(WindowCovering)).close()
    assert isinstance(outcome, NoAnswer)
    assert round(outcome.waited) == 10


@pytest.mark.parametrize(
    ("position", "expected", "sendings"), [(35.0, Confirmed, 1), (98.0, AlreadySo, 0), (None, AlreadySo, 0)]
)
async def test_what_is_open_in_part_is_opened_all_the_way(
    home: Home, position: float | None, expected: type[Outcome], sendings: int
) -> None:
    """A blind at 35 % is open, for it is not closed; who says open wants more than that."""
    blind = await home.new(WindowCovering, "blind", "movement", "position")
    values: dict[str, PlainValue] = {"movement": "open"} | ({} if position is None else {"position": position})
    await home.gateway.devices.report("blind", values)
    await anyio.sleep(1)
    home.behaviours["blind"] = on_the_way((2.0, {"movement": "open", "position": 100.0}))
    assert isinstance(await blind.open(), expected)
    assert len(home.commands) == sendings
