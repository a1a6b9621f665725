"""Who may command what: grants of apps, scopes of clients, and what always takes an explicit right."""

import tomllib
from dataclasses import replace

import pytest
from tests.control.conftest import Home, OpenHome, refusal
from tests.control.policies.houses import make_command, make_device, make_facts

from homebot.config import parse_config
from homebot.control import ControlSettings
from homebot.control.policy_engine import Policies
from homebot.devices import Device
from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.handles import DoorLock, Light
from homebot.devices.outcomes import Refused
from homebot.devices.value import Value
from homebot.errors import ConfigError
from homebot.runtime.plan import make_plan
from homebot.words.rights import read_scope

LAMP = make_device("lamp", "light", room="hall", settable=("on_off",))
LOCK = make_device("front_door", "door_lock", room="hall", settable=("lock",))
GARAGE = make_device("garage", "closure", room="yard", tag="garage_door", settable=("movement",))
VALVE = make_device("main", "water_valve", settable=("valve",))
COVER = make_device("cover", "window_covering", settable=("movement",))
FREEZER = make_device("freezer", "plug", room="kitchen", settable=("on_off",))
OVEN = make_device("oven", "plug", room="kitchen", settable=("on_off",))


def refused_by(scope: tuple[str, ...], device: Device, **settings: bool | str | float) -> str:
    """Return the policy that refuses an app of this scope the command; empty for none."""
    policies = Policies(ControlSettings(approvals=False))
    verdict = policies.check(make_command(device, settings, scope=scope), make_facts())[-1]
    return "" if verdict.allowed else verdict.policy


def test_a_grant_is_for_what_its_query_finds() -> None:
    assert refused_by(("act: light in hall",), LAMP, on_off=True) == ""
    assert refused_by(("act: light in attic",), LAMP, on_off=True) == "grants"
    assert refused_by(("act: light in attic", "act: light in hall"), LAMP, on_off=True) == ""
    assert refused_by(("read",), LAMP, on_off=True) == "grants"
    assert refused_by(("act: all",), LAMP, on_off=True) == ""
    assert refused_by((), LAMP, on_off=True) == ""


@pytest.mark.parametrize("scope", [(), ("act: in hall",), ("act: not light",)])
def test_a_lock_takes_a_right_that_names_it(scope: tuple[str, ...]) -> None:
    assert refused_by(scope, LOCK, lock="unlocked") == "always_ask"
    assert refused_by(scope, LOCK, lock="open") == "always_ask"


@pytest.mark.parametrize("scope", [("act: lock",), ("act: lock in hall",), ("act: name=front_door",), ("act: all",)])
def test_its_type_or_its_name_names_it(scope: tuple[str, ...]) -> None:
    assert refused_by(scope, LOCK, lock="unlocked") == ""


def test_the_safe_side_is_for_everybody_without_a_scope() -> None:
    assert refused_by((), LOCK, lock="locked") == ""
    assert refused_by((), GARAGE, movement="stopped") == ""
    assert refused_by((), VALVE, valve="closed") == ""
    assert refused_by((), OVEN, on_off=False) == ""
    assert refused_by(("act: light",), LOCK, lock="locked") == "always_ask"


def test_to_turn_off_a_setting_is_not_the_safe_side() -> None:
    """A lock that does not lock itself any more stands open."""
    relock = make_device("relock", "x_setting", settable=("on_off", "lock"))
    assert refused_by((), relock, on_off=False) == "always_ask"
    assert refused_by((), relock, lock="locked") == ""


def test_garage_doors_valves_and_ovens_always_ask() -> None:
    assert refused_by((), GARAGE, movement="open") == "always_ask"
    assert refused_by((), GARAGE, movement="closed") == "always_ask"
    assert refused_by((), VALVE, valve="open") == "always_ask"
    assert refused_by((), OVEN, on_off=True) == "always_ask"


def test_harmless_is_what_is_on_the_list_and_ordinary_what_does_not_always_ask() -> None:
    scope: tuple[str, ...]
    for scope in (("act: harmless",), ("act: ordinary",)):
        assert refused_by(scope, LAMP, on_off=True) == ""
        assert refused_by(scope, LOCK, lock="unlocked") == "always_ask"
        assert refused_by(scope, LOCK, lock="locked") == ""
        assert refused_by((*scope, "act: lock"), LOCK, lock="unlocked") == ""
    assert refused_by(("act: harmless",), FREEZER, on_off=True) == "harmless"
    for scope in (("act: ordinary",), (), ("act: harmless", "act: plug"), ("act: harmless", "act: in kitchen")):
        assert refused_by(scope, FREEZER, on_off=True) == ""


def test_to_turn_off_is_no_safe_side_if_nothing_says_what_goes_off() -> None:
    """It may be a freezer, or keep a person alive; the owner's apps may do so as ever."""
    breaker = make_device("breaker", "switch", tag="breaker", settable=("on_off",))
    tagged = FREEZER.model_copy(update={"tags": ("always ask",)})
    for device in (FREEZER, breaker, tagged):
        assert refused_by(("act: harmless",), device, on_off=False) in {"harmless", "always_ask"}
        assert refused_by((), device, on_off=False) == ""
    for device, settings in (
        (OVEN, {"on_off": False}),
        (GARAGE, {"movement": "stopped"}),
        (COVER, {"movement": "stopped"}),
    ):
        assert refused_by(("act: harmless",), device, **settings) == ""
    assert refused_by(("act: harmless",), COVER, movement="closed") == "harmless"


def test_a_thermostat_of_who_may_do_what_is_harmless_stays_within_its_range() -> None:
    thermostat = make_device("hall", "thermostat", settable=("heating_setpoint",))
    verdicts = [refused_by(("act: harmless",), thermostat, heating_setpoint=value) for value in (4.0, 21.0, 30.0)]
    assert verdicts == ["harmless", "", "harmless"]
    assert refused_by((), thermostat, heating_setpoint=30.0) == ""


def test_a_refusal_of_what_is_not_on_the_list_says_so_and_how_to_put_it_there() -> None:
    issuer, table = "/light_service", "apps.light_service"
    command = make_command(FREEZER, {"on_off": True}, scope=("act: harmless",), issuer=issuer)
    command = replace(command, rights=command.rights._replace(table=f"[{table}]"))
    reason = Policies(ControlSettings()).check(command, make_facts())[-1].reason
    why = "it is not on the list of harmless devices (nothing but its name says what this plug turns on)"
    step = "if it can hurt nobody, `homebot tag add freezer harmless`, otherwise"
    line = f"""[{table}] act = ['harmless', 'id="freezer"'] gives one"""
    assert reason == f"freezer needs a right, because {why}, and {issuer} has none; {step} {line}"


HOUSE = """
[apps.light_service]
[apps.hall]
class = "homebot.apps.lights_out:LightsOut"
"""
ROUTINE = """
[[routines]]
name = "Good night"
when = ["22:30"]
do = ["all lights off"]
"""
PLACES = {one: f"[apps.{one}]" for one in ("light_service", "hall")} | {"good_night": 'name = "Good night"'}


@pytest.mark.parametrize(
    ("issuer", "house"),
    [
        ("light_service", HOUSE),
        ("hall", HOUSE),
        pytest.param("good_night", HOUSE + ROUTINE, marks=pytest.mark.rooms("routines")),
        ("a_program", HOUSE),
    ],
)
@pytest.mark.parametrize(
    ("scope", "act"),
    [
        ((), """['ordinary', 'id="front_door"']"""),
        (("act: ordinary",), """['ordinary', 'id="front_door"']"""),
        (("act: light", "act: plug"), """['light', 'plug', 'id="front_door"']"""),
        (("act: harmless",), """['harmless', 'id="front_door"']"""),
        (("read",), """['id="front_door"']"""),
    ],
)
def test_a_refusal_has_the_line_that_allows_it_in_the_configuration(
    scope: tuple[str, ...], act: str, issuer: str, house: str
) -> None:
    """As a table [apps.good_night] is of no app, nor of a routine, it made the configuration invalid."""
    tables = make_plan(parse_config(tomllib.loads(house), "homebot.toml")).grants.now.tables
    command = make_command(LOCK, {"lock": "unlocked"}, scope=scope, issuer=f"/{issuer}")
    command = replace(command, rights=command.rights._replace(table=tables.get(f"/{issuer}", "")))
    reason = Policies(ControlSettings(approvals=False)).check(command, make_facts())[-1].reason
    right = "front_door needs a right that names it (it is a door lock)"
    lines = {
        "light_service": f"[apps.light_service] act = {act} gives one",
        "hall": f"[apps.hall] act = {act} gives one",
        "good_night": f"in [[routines]] 'Good night': act = {act} gives one",
        "a_program": "only an app or a routine can have one, by its key `act`",
    }
    assert reason == f"{right}, and /{issuer} has none; {lines[issuer]}"
    if issuer not in PLACES:
        return
    written = house.replace(PLACES[issuer], f"{PLACES[issuer]}\nact = {act}")
    granted = make_plan(parse_config(tomllib.loads(written), "homebot.toml")).grants.now.scopes[f"/{issuer}"]
    allowed = replace(command, rights=read_scope(granted))
    assert Policies(ControlSettings(approvals=False)).check(allowed, make_facts())[-1].allowed


def test_the_table_of_an_app_says_what_it_may_command() -> None:
    tables = {"apps": {"light_service": {"act": ["light in hall", "plug"]}}, "gateways": {"mqtt": {}}}
    plan = make_plan(parse_config(tables, "homebot.toml"))
    assert plan.grants.now.scopes == {"/light_service": ("act: light in hall", "act: plug")}


@pytest.mark.parametrize("act", [5, "(light"])
def test_an_app_with_a_wrong_grant_is_left_out(act: object) -> None:
    tables: dict[str, object] = {"apps": {"light_service": {"act": act}}}
    plan = make_plan(parse_config(tables, "homebot.toml"))
    assert not plan.apps
    error = plan.left_out["apps.light_service"]
    assert isinstance(error, ConfigError)
    assert error.key == "apps.light_service.act"


@pytest.mark.virtual_time
async def test_an_app_commands_what_is_granted(open_home: OpenHome) -> None:
    async with open_home(grants={"/app": ("act: light in hall",)}) as home:
        home.put("lamp", "light", "on_off", area="hall")
        home.put("other", "light", "on_off", area="attic")
        assert (await (await home.handle(Light, "lamp")).turn_on()).succeeded
        reason = await refusal((await home.handle(Light, "other")).turn_on())
        assert reason == "/app may not command other, only: act: light in hall"
        home.put("new one", "light", "on_off")
        reason = await refusal((await home.handle(Light, "new one")).turn_on())
        assert reason.endswith("only: act: light in hall; it has no room: homebot place 'New One' ROOM")


@pytest.mark.virtual_time
async def test_an_app_without_the_right_does_not_unlock(home: Home) -> None:
    lock = await home.new(DoorLock, "lock", "lock")
    outcome = await lock.unlock()
    assert isinstance(outcome, Refused)
    assert outcome.policy == "always_ask"
    assert home.commands == []
    assert (await lock.lock()).succeeded


@pytest.mark.virtual_time
async def test_a_client_with_the_right_unlocks_and_a_wrong_scope_is_refused(home: Home) -> None:
    lock = await home.new(DoorLock, "lock", "lock")
    unlock = Setting(capability="lock", value=Value.of("unlocked"))

    async def outcome(*scope: str) -> str:
        request = CommandRequest(device=lock.device.id, part="", settings=(unlock,), issuer="client:phone", scope=scope)
        return (await home.control.perform(request)).kind

    assert await outcome("act: lights") == "refused"
    assert await outcome("unlock everything") == "refused"
    assert await outcome("act: lock") == "confirmed"
