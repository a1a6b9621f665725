"""Fights of two apps over one part."""

from typing import TypeAlias

import anyio
import pytest
from structlog.testing import capture_logs
from tests.control.conftest import Home, OpenHome

from homebot.control.journal.fights import Fights, Turn, is_fight
from homebot.devices import Devices
from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.handles import Light
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.journal_messages import DeviceFight, ExplainDevice, ExplainDeviceRequest
from homebot.devices.names import EXPLAIN_DEVICE
from homebot.devices.value import PlainValue
from homebot.graph import Node

Values: TypeAlias = dict[str, PlainValue]

ON: Values = {"on_off": True}
OFF: Values = {"on_off": False}


def turns(issuers: str, values: list[Values], times: tuple[float, ...]) -> list[Turn]:
    return [Turn(at, issuer, value, "lamp") for at, issuer, value in zip(times, issuers, values, strict=True)]


FIGHTS: list[tuple[str, list[Values], tuple[float, ...]]] = [
    ("abab", [ON, OFF, ON, OFF], (0, 10, 20, 30)),
    ("abab", [ON, OFF, ON, OFF], (0, 30, 300, 330)),  # two short gaps of three
    ("abab", [{"level": 40.0}, OFF, {"level": 41.0}, OFF], (0, 1, 2, 3)),
]
PEACES: list[tuple[str, list[Values], tuple[float, ...]]] = [
    ("abab", [ON, OFF, ON, OFF], (0, 31, 62, 80)),  # one short gap
    ("abab", [ON, OFF, ON, OFF], (0, 10, 20, 601)),  # too long
    ("abab", [ON, ON, ON, ON], (0, 1, 2, 3)),  # of one mind
    ("abab", [ON, {"color_temperature": 250.0}, ON, {"color_temperature": 300.0}], (0, 1, 2, 3)),
    ("abac", [ON, OFF, ON, OFF], (0, 1, 2, 3)),
    ("aaaa", [ON, OFF, ON, OFF], (0, 1, 2, 3)),  # blinking
    ("aba", [ON, OFF, ON], (0, 1, 2)),
]


@pytest.mark.parametrize(("issuers", "values", "times"), FIGHTS + PEACES)
def test_two_apps_fight_if_they_command_in_turn_against_each_other_and_quickly(
    issuers: str, values: list[Values], times: tuple[float, ...]
) -> None:
    assert is_fight(turns(issuers, values, times)) is ((issuers, values, times) in FIGHTS)


@pytest.mark.parametrize(
    ("seen", "is_a_fight"), [((True, False, True, False), False), ((True, True, True, True), True)]
)
def test_two_apps_that_follow_one_sensor_do_not_fight(seen: tuple[bool, ...], *, is_a_fight: bool) -> None:
    """One turns the light on where a room is occupied, the other off where it is clear."""
    sensor = ("hall_motion", "", "occupied")
    given = turns("abab", [ON, OFF, ON, OFF], (0, 10, 20, 30))
    assert (
        is_fight([one._replace(sensed={sensor: value}) for one, value in zip(given, seen, strict=True)]) is is_a_fight
    )


def test_a_fight_begins_once_counts_on_and_is_shown_for_an_hour() -> None:
    fights, begun = Fights(), list[DeviceFight]()
    for number in range(100):
        turn = Turn(number * 10.0, "/a" if number % 2 else "/b", ON if number % 2 else OFF, "lamp")
        begun += [one for one in [fights.add(("lamp", ""), turn)] if one is not None]
    assert [one.commands for one in begun] == [4]
    (fight,) = fights.recent(990.0 + 3600, "lamp")
    assert (fight.commands, sorted(fight.issuers), fight.newest.sec) == (100, ["/a", "/b"], 990)
    assert fight.text == "b (off) and a (on) fight over lamp: 100 commands in 990 s"
    assert (fights.recent(990.0 + 3601), fights.recent(990.0, "other")) == ((), ())


def test_an_app_that_repeats_itself_has_one_turn() -> None:
    fights = Fights()
    found = [fights.add(("lamp", ""), one) for one in turns("aabbaabb", [ON, ON, OFF, OFF] * 2, tuple(range(8)))]
    assert [one is not None for one in found] == [False] * 6 + [True, False]


def test_the_parts_that_are_watched_are_bounded() -> None:
    fights = Fights()
    for number in range(5000):
        for turn in turns("abab", [ON, OFF, ON, OFF], (0, 1, 2, 3)):
            fights.add((str(number), ""), turn)
    assert len(fights.recent(0.0)) == 1000


async def quarrel(home: Home, issuers: tuple[str, str], rounds: int) -> None:
    """Command the lamp on and off in turn, each as another node."""
    async with Node(home.graph, issuers[0]) as first, Node(home.graph, issuers[1]) as second:
        await anyio.sleep(0.1)
        lamps = [(await Devices(node).find(Light))[0] for node in (first, second)]
        for _ in range(rounds):
            await lamps[0].turn_on()
            await anyio.sleep(5)
            await lamps[1].turn_off()
            await anyio.sleep(5)


@pytest.mark.virtual_time
async def test_a_fight_is_a_line_of_the_log_a_trouble_of_control_and_an_answer_to_why(home: Home) -> None:
    home.put("lamp", "light", "on_off")
    await home.report("lamp", "on_off", False)
    with capture_logs() as lines:
        await quarrel(home, ("mornings", "night"), rounds=5)
    told = [one["message"] for one in lines if one["event"] == "control.fight"]
    assert told == ["mornings (on) and night (off) fight over lamp: 4 commands in 15 s; see homebot why lamp"]
    health = await home.app.create_client(GetHealth, "/control/health").call(HealthRequest())
    found = await home.app.create_client(ExplainDevice, EXPLAIN_DEVICE).call(ExplainDeviceRequest(device="lamp"))
    text = "mornings (on) and night (off) fight over lamp: 10 commands in 45 s"
    assert health.troubles == (f"{text}, the last 5 s ago; see homebot why lamp",)
    assert [one.text for one in found.fights] == [text]


@pytest.mark.virtual_time
async def test_an_app_whose_commands_are_refused_fights_with_none(open_home: OpenHome) -> None:
    async with open_home(grants={"/night": ("act: lock",)}) as home:
        home.put("lamp", "light", "on_off")
        await home.report("lamp", "on_off", False)
        with capture_logs() as lines:
            await quarrel(home, ("mornings", "night"), rounds=5)
        assert not [one for one in lines if one["event"] == "control.fight"]


@pytest.mark.virtual_time
async def test_a_person_at_a_client_fights_with_no_app(home: Home) -> None:
    lamp = await home.lamp("on_off")
    with capture_logs() as lines:
        for _ in range(5):
            await lamp.turn_on()
            await anyio.sleep(5)
            wish = CommandRequest(
                device="lamp", settings=(Setting.of("on_off", False),), issuer="client:anna", scope=("act: all",)
            )
            assert (await home.control.perform(wish)).succeeded
            await anyio.sleep(5)
    assert not [one for one in lines if one["event"] == "control.fight"]
