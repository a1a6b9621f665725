"""Sensors that observe what commands do: named by the owner, or a meter of the same device; in virtual time."""

import anyio
import pytest
from tests.control.conftest import Behaviour, Home, OpenHome, obey, obey_after

from homebot.control import ControlSettings
from homebot.control.gateway_feed import GatewayFeed
from homebot.control.witnesses import Observed, Witnesses, observed
from homebot.devices.approval_messages import TrustDevice, TrustDeviceRequest
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import DoorLock, Light, Switch, WindowCovering
from homebot.devices.health import HealthRequest
from homebot.devices.names import TRUST_DEVICE
from homebot.devices.outcomes import Confirmed, Contradicted, Evidence, Superseded
from homebot.devices.value import PlainValue

pytestmark = pytest.mark.virtual_time

NAMED = {"light": "Lux"}


@pytest.fixture
def home_settings() -> dict[str, object]:
    return {"witnesses": NAMED}


def shining(lux: float, after: float = 0.2) -> Behaviour:
    """Obey, and let the sensor measure so much, or nothing, so many seconds later."""

    async def behaviour(home: Home, command: Command) -> None:
        await obey(home, command)
        home.later(after, "lux", "illuminance", lux if command.value.plain() else 0.0)

    return behaviour


async def room(home: Home, behaviour: Behaviour, lux: float = 0.0) -> Light:
    home.put("lamp", "light", "on_off")
    home.put("lux", "light_sensor", readable=("illuminance",))
    home.behaviours["lamp"] = behaviour
    await home.report("lamp", "on_off", False)
    await home.report("lux", "illuminance", lux)
    return await home.handle(Light, "lamp")


async def lie(home: Home, command: Command) -> None:
    """Report "on", and stay dark; the sensor goes on to report."""
    await obey(home, command)
    for seconds in (1.0, 3.0, 5.0):
        home.later(seconds, "lux", "illuminance", 0.0)


async def test_a_named_sensor_that_sees_the_effect_is_the_witness(home: Home) -> None:
    lamp = await room(home, shining(150.0))
    for _ in range(2):
        for outcome in (await lamp.turn_on(), await lamp.turn_off()):
            assert isinstance(outcome, Confirmed)
            assert (outcome.evidence, outcome.witness) == (Evidence.WITNESSED, "Lux")
            assert outcome.latency == pytest.approx(0.2)


async def test_a_lamp_that_only_says_that_it_is_on_is_contradicted(home: Home) -> None:
    lamp = await room(home, lie)
    outcome = await lamp.turn_on()
    assert outcome == Contradicted("Lux measured no change", "Lux", command_id=outcome.command_id)


async def test_a_contradicted_lamp_is_told_the_same_again(home: Home) -> None:
    """Its report counts no more, until the sensor sees it obey."""
    lamp = await room(home, lie)
    assert isinstance(await lamp.turn_on(), Contradicted)
    assert len((await home.control.health(HealthRequest())).notes) == 1
    home.commands.clear()
    home.behaviours["lamp"] = shining(150.0)
    assert isinstance(await lamp.turn_on(), Confirmed)
    assert len(home.commands) == 1
    assert (await home.control.health(HealthRequest())).notes == ()


async def test_the_owner_trusts_a_contradicted_lamp_again(home: Home) -> None:
    lamp = await room(home, lie)
    await lamp.turn_on()
    trust, request = home.app.create_client(TrustDevice, TRUST_DEVICE), TrustDeviceRequest(device=lamp.device.id)
    assert (await trust.call(request)).witnesses == ("Lux",)
    assert (await trust.call(request)).witnesses == ()
    assert (await home.control.health(HealthRequest())).notes == ()


async def test_the_oldest_of_more_than_a_thousand_contradicted_parts_is_forgotten_and_counted(home: Home) -> None:
    witnesses = Witnesses(home.app, ControlSettings(), GatewayFeed(home.app), DeviceLookup(home.app))
    for number in range(1001):
        witnesses.contradicted[f"lamp{number}", ""] = "Lux"
    assert len(witnesses.notes()) == 1000
    assert ("lamp0", "") not in witnesses.contradicted
    assert witnesses.counts["contradictions_forgotten"] == 1


async def test_a_silent_sensor_contradicts_no_lamp(home: Home) -> None:
    outcome = await (await room(home, obey)).turn_on()
    assert isinstance(outcome, Confirmed)
    assert outcome.evidence is Evidence.REPORTED


async def test_a_lamp_in_daylight_is_not_contradicted(home: Home) -> None:

    async def obey_by_day(home: Home, command: Command) -> None:
        await obey(home, command)
        home.later(1.0, "lux", "illuminance", 5000.0)

    lamp = await room(home, obey_by_day, lux=5010.0)
    for outcome in (await lamp.turn_on(), await lamp.turn_off()):
        assert isinstance(outcome, Confirmed)
        assert outcome.evidence is Evidence.REPORTED


async def test_a_sensor_that_nobody_named_is_no_witness_and_is_not_waited_for(open_home: OpenHome) -> None:
    async with open_home(witnesses={"plug": "Lux"}) as home:
        lamp = await room(home, shining(150.0))
        began = anyio.current_time()
        outcome = await lamp.turn_on()
        assert isinstance(outcome, Confirmed)
        assert (outcome.evidence, anyio.current_time() - began) == (Evidence.REPORTED, 0.0)


async def test_a_witness_makes_up_for_a_lost_report(home: Home) -> None:

    async def obey_in_silence(home: Home, command: Command) -> None:
        home.later(0.3, "lux", "illuminance", 150.0)

    outcome = await (await room(home, obey_in_silence)).turn_on()
    assert isinstance(outcome, Confirmed)
    assert outcome.evidence is Evidence.WITNESSED


async def test_a_newer_command_ends_the_wait_for_a_witness(home: Home) -> None:
    lamp = await room(home, obey)
    found = home.begin(lamp.turn_on)
    await anyio.sleep(1)
    home.behaviours["lamp"] = shining(0.0)
    await lamp.turn_off()
    assert [type(one) for one in found] == [Superseded]


async def test_the_power_of_a_plug_witnesses_it_without_a_wait(open_home: OpenHome) -> None:
    async with open_home() as home:

        async def draw(home: Home, command: Command) -> None:
            is_on = command.value.plain() is True
            await home.gateway.devices.report("plug", {"power": 40.0 if is_on else 0.0, "on_off": is_on})

        home.put("plug", "switch", "on_off", readable=("power",))
        home.behaviours["plug"] = draw
        await home.gateway.devices.report("plug", {"on_off": False, "power": 0.0})
        plug = await home.handle(Switch, "plug")
        outcome = await plug.turn_on()
        assert isinstance(outcome, Confirmed)
        assert (outcome.evidence, outcome.witness) == (Evidence.WITNESSED, "Plug")
        home.behaviours["plug"] = obey_after(0.1)  # nothing is plugged in any more
        began = anyio.current_time()
        outcome = await plug.turn_off()
        assert isinstance(outcome, Confirmed)
        assert outcome.evidence is Evidence.REPORTED
        assert anyio.current_time() - began == pytest.approx(0.1)


async def test_a_contact_sees_a_blind_and_a_bolt_sensor_a_lock(open_home: OpenHome) -> None:
    names = {"window_covering": "Contact", "door_lock": "Bolt"}
    async with open_home(witnesses=names, always_ask=False) as home:
        home.put("blind", "window_covering", "movement")
        home.put("contact", "contact_sensor", readable=("contact",))
        home.put("lock", "door_lock", "lock")
        home.put("bolt", "contact_sensor", readable=("unlocked",))

        async def move(home: Home, command: Command) -> None:
            await obey(home, command)
            home.later(0.2, "contact", "contact", command.value.plain() == "open")

        home.behaviours["blind"] = move
        await home.report("contact", "contact", False)
        await home.report("bolt", "unlocked", True)
        outcome = await (await home.handle(WindowCovering, "blind")).open()
        assert isinstance(outcome, Confirmed)
        assert outcome.witness == "Contact"
        outcome = await (await home.handle(DoorLock, "lock")).lock()
        assert outcome.text == "contradicted: Bolt measured no change"


@pytest.mark.parametrize(
    ("capability", "before", "newest", "is_rise", "is_heard", "expected"),
    [
        ("power", 0.0, 40.0, True, True, Observed.EFFECT),
        ("power", 0.0, 0.4, True, True, Observed.NOTHING),
        ("power", 200.0, 205.0, True, True, Observed.UNCLEAR),
        ("power", 40.0, 40.0, False, True, Observed.NOTHING),
        ("power", 40.0, 40.0, False, False, Observed.UNCLEAR),
        ("power", 40.0, 0.0, False, True, Observed.EFFECT),
        ("illuminance", 150.0, 150.0, False, True, Observed.UNCLEAR),
        ("illuminance", 1.0, 1.0, True, True, Observed.NOTHING),
        ("contact", True, True, True, True, Observed.UNCLEAR),
        ("contact", False, None, True, True, Observed.UNCLEAR),
    ],
)
def test_a_sensor_shows_an_effect_nothing_or_cannot_tell(
    capability: str, before: PlainValue, newest: PlainValue, expected: Observed, *, is_rise: bool, is_heard: bool
) -> None:
    assert observed(capability, before, newest, is_rise=is_rise, is_heard=is_heard) is expected
