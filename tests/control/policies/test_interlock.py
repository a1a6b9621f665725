"""Interlocks: no heating while a window is open, or while nobody knows."""

from collections.abc import Mapping

import anyio
import pytest
from tests.control.conftest import OpenHome
from tests.control.policies.houses import NONE, make_command, make_device, make_facts

from homebot.config import parse_settings
from homebot.control import ControlSettings
from homebot.control.policies import Verdict
from homebot.control.policy_engine import Policies
from homebot.devices import Device, Freshness
from homebot.devices.command_messages import CommandRequest, CommandResult, Setting
from homebot.devices.device import Reachability
from homebot.devices.handles import Thermostat
from homebot.devices.outcomes import Confirmed, Refused
from homebot.devices.value import PlainValue, Value
from homebot.errors import ConfigError

WINDOW = [{"commands": ["heat"], "while": "open contact sensor"}]


HEAT: Mapping[str, PlainValue] = {"heating_setpoint": 22.0}


def judge(device: Device, *house: Device, settings: Mapping[str, PlainValue] = HEAT, where: str = "room") -> Verdict:
    table = {"interlocks": [{**WINDOW[0], "where": where}]}
    policies = Policies(parse_settings(ControlSettings, table, "homebot.toml", "control"))
    verdicts = policies.check(make_command(device, settings), make_facts(*house))
    return next(one for one in verdicts if one.policy == "interlock")


def heater(room: str = "Bath", values: Mapping[str, PlainValue] = NONE) -> Device:
    return make_device(
        "heater", "thermostat", room=room, settable=("heating_setpoint", "thermostat_mode"), values=values
    )


def window(
    *, contact: PlainValue = True, room: str = "bath", freshness: Freshness = "fresh", is_live: bool = True
) -> Device:
    return make_device(
        "window", "contact_sensor", room=room, freshness=freshness, is_live=is_live, values={"contact": contact}
    )


def test_no_heating_while_the_window_is_open() -> None:
    verdict = judge(heater(), window())
    assert not verdict.allowed
    assert verdict.reason == "not while open contact sensor: window"
    assert [(one.name, one.value) for one in verdict.facts] == [("contact of window", True)]


def test_heating_while_it_is_closed() -> None:
    assert judge(heater(), window(contact=False)).allowed


def test_less_heat_is_always_fine() -> None:
    assert judge(heater(values={"heating_setpoint": 21.0}), window(), settings={"heating_setpoint": 7.0}).allowed
    assert judge(heater(), window(), settings={"thermostat_mode": "off"}).allowed


def test_the_window_of_another_room_does_not_matter() -> None:
    assert judge(heater(), window(room="attic")).allowed
    assert not judge(heater(), window(room="attic"), where="home").allowed


@pytest.mark.parametrize(("contact", "allowed"), [(False, True), (True, False)])
def test_a_retained_report_of_a_contact_that_is_there_counts(*, contact: bool, allowed: bool) -> None:
    """Or nobody could heat after a restart until every battery contact has spoken, which takes hours."""
    kept = window(contact=contact, freshness="unconfirmed", is_live=False)
    there = kept.model_copy(update={"reachable": Reachability(state="yes")})
    assert judge(heater(), there).allowed is allowed
    assert not judge(heater(), kept).allowed


def heating_to(celsius: float) -> CommandRequest:
    setting = Setting(capability="heating_setpoint", value=Value.of(celsius))
    return CommandRequest(device="heater", settings=(setting,), issuer="client:owner", scope=("act: all",))


@pytest.mark.virtual_time
async def test_a_person_passes_with_a_warning_while_the_state_of_a_window_is_unknown(open_home: OpenHome) -> None:
    async with open_home(interlocks=WINDOW) as home:
        home.put("heater", "thermostat", "heating_setpoint", area="Bath")
        home.put("window", "contact_sensor", readable=("contact",), area="bath")
        heater = await home.handle(Thermostat, "heater")
        assert isinstance(await heater.heat_to(22.0), Refused)
        outcome = await home.control.perform(heating_to(22.0))
        assert isinstance(outcome, Confirmed)
        assert "the state of Window is unknown: it has reported nothing yet" in outcome.warning
        assert CommandResult.of(outcome).text.endswith(outcome.warning)
        await home.report("window", "contact", True)
        await anyio.sleep(0.01)
        assert isinstance(await home.control.perform(heating_to(23.0)), Refused)


def test_a_silent_contact_means_no() -> None:
    assert not judge(heater(), window(contact=False, freshness="stale")).allowed
    assert not judge(heater(), window(contact=None)).allowed
    assert not judge(heater(), window(contact=False, is_live=False)).allowed


@pytest.mark.parametrize(
    ("contact", "why"),
    [
        (window(contact=False, freshness="stale"), "it has been silent for too long"),
        (window(contact=False, freshness="unconfirmed"), "it has reported nothing yet since homebot started"),
        (window(contact=False, is_live=False), "it has reported nothing yet since homebot started"),
    ],
)
def test_the_reason_says_why_the_state_of_a_contact_is_unknown(contact: Device, why: str) -> None:
    verdict = judge(heater(), contact)
    assert verdict.reason == f"not while open contact sensor, and the state of window is unknown: {why}"


def test_a_heater_without_a_room_means_no() -> None:
    assert not judge(heater(room=""), window()).allowed


def test_a_condition_that_is_no_query_is_an_error() -> None:
    with pytest.raises(ConfigError, match="while"):
        parse_settings(ControlSettings, {"interlocks": [{"commands": ["heat"], "while": "(open"}]}, "x", "control")


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ({"commands": ["heat"], "while": "opn window"}, "'opn window': 'opn' is neither a type nor a capability"),
        ({"commands": ["heat heater_"], "while": "open window"}, "'heat heater_': 'heater' is neither a type nor"),
        ({"commands": ["heat thermstat"], "while": "open window"}, "did you mean thermostat?"),
    ],
)
def test_a_misspelt_word_is_an_error_as_it_would_stop_nothing(table: dict[str, object], problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        parse_settings(ControlSettings, {"interlocks": [table]}, "x", "control")


@pytest.mark.virtual_time
async def test_the_control_layer_knows_the_windows(open_home: OpenHome) -> None:
    async with open_home(interlocks=WINDOW) as home:
        home.put("heater", "thermostat", "heating_setpoint", area="bath")
        home.put("window", "contact_sensor", readable=("contact",), area="bath")
        await home.report("window", "contact", True)
        heater = await home.handle(Thermostat, "heater")
        assert isinstance(await heater.heat_to(22.0), Refused)
        await home.report("window", "contact", False)
        await home.handle(Thermostat, "heater")
        assert (await heater.heat_to(22.0)).succeeded
