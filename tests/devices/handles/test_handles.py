"""What handles find, tell and are told; in virtual time."""

from collections.abc import Awaitable, Callable
from typing import Any

import anyio
import pytest
from structlog.testing import capture_logs
from tests.devices.handles.conftest import House

from homebot.devices.gateway_messages import SendCommandResponse
from homebot.devices.handles import (
    AirConditioner,
    AlarmPanel,
    Closure,
    ContactSensor,
    DoorLock,
    ElectricalMeter,
    Fan,
    Handle,
    HumiditySensor,
    LawnMower,
    Light,
    LightSensor,
    MediaPlayer,
    OccupancySensor,
    Plug,
    PressureSensor,
    RoboticVacuumCleaner,
    Siren,
    SmokeAlarm,
    Switch,
    TemperatureSensor,
    Thermostat,
    WaterLeakDetector,
    WaterValve,
    WindowCovering,
)
from homebot.devices.outcomes import Gone, Outcome
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, ServiceUnavailableError, UsageError

pytestmark = pytest.mark.virtual_time

LAMP = ("on_off", "level", "color_temperature", "color", "effect")


async def test_find_gives_handles_of_the_kind_alone(house: House) -> None:
    """In the order of the directory, whatever else is in the house."""
    house.has(
        house.device("a", house.part("light", "on_off"), on_off=True),
        house.device("b", house.part("plug", "on_off"), on_off=True),
        house.device("c", house.part("light", "on_off"), on_off=None),
    )
    lamps = await house.devices.find(Light)
    assert [(type(one), one.id, one.on) for one in lamps] == [(Light, "a", True), (Light, "c", None)]
    assert [one.id for one in await house.devices.find(Handle)] == ["a", "b", "c"]


async def test_each_part_of_a_device_is_a_handle_of_its_own(house: House) -> None:
    """Settings and self-observations are not what somebody means who asks for a switch."""
    house.has(
        house.device(
            "strip",
            house.part("switch", "on_off", part_id="1", name="left"),
            house.part("switch", "on_off", part_id="2"),
            house.part("switch", "on_off", part_id="led", category="config"),
            area="Küche",
        )
    )
    left, right = await house.devices.find(Switch)
    assert (left.id, left.name, left.area) == ("strip#1", "Strip left", "Küche")
    assert (right.id, right.name) == ("strip#2", "Strip")
    assert left != right
    (led,) = await house.devices.find(Switch, category="config")
    assert led.id == "strip#led"
    assert await house.devices.find(Switch, category="diagnostic") == ()
    assert await house.devices.find(Handle, category="config", area="attic") == ()
    house.gateway("mqtt")
    await led.turn_off()
    assert house.told == [("mqtt", "led", "on_off", False, 0.0)]
    assert left == (await house.devices.find(Switch, name="LEFT"))[0]
    assert {left, *await house.devices.find(Switch)} == {left, right}
    assert repr(left) == "<Switch strip#1>"
    house.tells("changed", house.device("strip", house.part("switch", "on_off", part_id="1")))
    await anyio.sleep(0.01)
    assert left.id == "strip#1"
    assert left in {left: "stays the same, whatever else its device offers"}


async def test_a_query_is_about_the_part_and_its_device(house: House) -> None:
    """Case and accents do not matter; what a part has not told fits nothing."""
    house.has(
        house.device("on", house.part("light", "on_off", "level"), area="Küche", on_off=True),
        house.device("off", house.part("light", "on_off"), area="Küche", on_off=False),
        house.device("unknown", house.part("light", *LAMP), area="Bad"),
    )

    async def ids(**query: Any) -> list[str]:
        return [one.id for one in await house.devices.find(Light, **query)]

    assert await ids(area="kuche") == ["on", "off"]
    assert await ids(area='"') == await ids(area=" ") == []
    assert await ids(area="") == []
    assert await ids(on=True) == ["on"]
    assert await ids(on=False) == ["off"]
    assert await ids(dimmable=True) == ["on", "unknown"]
    assert await ids(dimmable=False) == ["off"]
    assert await ids(colored=True, tunable=True) == ["unknown"]
    assert await ids(name="UNKNOWN") == ["unknown"]
    assert await ids(fresh=False) == []
    assert await ids(reachable=True) == []


@pytest.mark.parametrize(
    ("kind", "capability", "value", "query"),
    [
        (WindowCovering, "movement", "closed", {"closed": True}),
        (Closure, "movement", "opening", {"closed": False}),
        (WaterValve, "valve", "open", {"closed": False}),
        (DoorLock, "lock", "locked", {"locked": True}),
        (DoorLock, "lock", "jammed", {"locked": False}),
        (Thermostat, "local_temperature", 17.5, {"below": 18}),
        (Thermostat, "thermostat_mode", "heat", {"mode": "heat"}),
        (Thermostat, "thermostat_mode", "Heat Up", {"mode": "heat_up"}),
        (Thermostat, "local_temperature", 1e-7, {"above": 1e-8}),
        (AirConditioner, "local_temperature", 27.0, {"above": 26}),
        (Fan, "on_off", True, {"on": True}),
        (Plug, "on_off", False, {"on": False}),
        (Siren, "on_off", True, {"on": True}),
        (RoboticVacuumCleaner, "vacuum", "docked", {"state": "docked"}),
        (LawnMower, "mower", "mowing", {"state": "mowing"}),
        (MediaPlayer, "playback", "paused", {"state": "paused"}),
        (ContactSensor, "contact", True, {"is_open": True}),
        (OccupancySensor, "occupancy", False, {"occupied": False}),
        (WaterLeakDetector, "water_leak", True, {"wet": True}),
        (SmokeAlarm, "smoke", True, {"smoke": True}),
        (TemperatureSensor, "temperature", 4.0, {"below": 5}),
        (HumiditySensor, "humidity", 61.0, {"above": 60}),
        (LightSensor, "illuminance", 3.0, {"below": 10}),
        (PressureSensor, "pressure", 990.0, {"below": 1000}),
        (ElectricalMeter, "power", 2500.0, {"above": 2000}),
    ],
)
async def test_every_kind_can_be_asked_for_by_its_state(
    house: House, kind: Any, capability: str, value: PlainValue, query: dict[str, Any]
) -> None:
    """The one that told nothing is never found."""
    service_type = min(kind.service_types)
    house.has(
        house.device("told", house.part(service_type, reads=[capability]), states={capability: value}),
        house.device("silent", house.part(service_type, reads=[capability])),
    )
    assert [one.id for one in await house.devices.find(kind, **query)] == ["told"]


@pytest.mark.parametrize(
    ("kind", "states", "told"),
    [
        (
            Light,
            {"on_off": True, "level": 40.0, "color_temperature": 2700.0, "color": (120.0, 50.0), "effect": "rainbow"},
            {"on": True, "level": 40.0, "kelvin": 2700.0, "color": (120.0, 50.0), "effect": "rainbow"},
        ),
        (Light, {"on_off": False, "level": 90.0}, {"on": False, "level": 90.0}),
        (Plug, {"on_off": False, "power": 3.5}, {"on": False, "power": 3.5}),
        (WindowCovering, {"position": 30.0, "tilt": 5.0, "movement": "stopped"}, {"position": 30.0, "tilt": 5.0}),
        (DoorLock, {"lock": "unlocked"}, {"state": "unlocked", "locked": False}),
        (DoorLock, {"lock": "jammed"}, {"state": "jammed", "locked": None}),
        (
            Thermostat,
            {"local_temperature": 20.5, "heating_setpoint": 21.0, "thermostat_mode": "heat", "cooling_setpoint": 25.0},
            {"temperature": 20.5, "heating_setpoint": 21.0, "mode": "heat", "cooling_setpoint": 25.0, "action": None},
        ),
        (Fan, {"fan_speed": 66.0}, {"on": True}),
        (Fan, {"fan_speed": 0.0, "fan_mode": "low"}, {"on": False}),
        (Fan, {"fan_mode": "OFF"}, {"on": False, "mode": "OFF"}),
        (Fan, {"on_off": None, "fan_mode": "low"}, {"on": True}),
        (Fan, {"on_off": None}, {"on": None}),
        (Fan, {"on_off": True, "fan_speed": 66.0, "fan_mode": "auto"}, {"on": True, "speed": 66.0, "mode": "auto"}),
        (WaterValve, {"valve": "open", "position": 100.0}, {"movement": "open", "position": 100.0}),
        (RoboticVacuumCleaner, {"vacuum": "docked", "battery": 80.0}, {"state": "docked", "battery": 80.0}),
        (ElectricalMeter, {"power": 5.0, "energy": 1.25}, {"watts": 5.0, "kilowatt_hours": 1.25}),
        (SmokeAlarm, {"carbon_monoxide_alarm": True}, {"smoke": None, "carbon_monoxide": True}),
        (TemperatureSensor, {"temperature": 21.0}, {"celsius": 21.0}),
        (ContactSensor, {"contact": True}, {"is_open": True}),
        (Light, {"on_off": "yes", "color": (1.0,)}, {"on": None, "color": None, "level": None}),
    ],
)
async def test_a_handle_has_the_values_of_its_part(
    house: House, kind: Any, states: dict[str, PlainValue], told: dict[str, PlainValue]
) -> None:
    """In the vocabulary's units; what was not told, or is of another type, is None."""
    (service_type,) = kind.service_types
    house.has(house.device("a", house.part(service_type, reads=states), states=states))
    (handle,) = await house.devices.find(kind)
    assert {name: getattr(handle, name) for name in told} == told
    assert handle.device.id == "a"


@pytest.mark.parametrize(
    ("capability", "problem"),
    [
        ("vibratoin", "'vibratoin' is not a capability; did you mean vibration?"),
        ("xyz", "'xyz' is not a capability; a reports on_off"),
        ("press", "press is an event, not a state"),
    ],
)
async def test_a_value_that_cannot_be_is_an_error_rather_than_unknown(
    house: House, capability: str, problem: str
) -> None:
    house.has(house.device("a", house.part("light", "on_off"), on_off=True))
    (lamp,) = await house.devices.find(Light)
    with pytest.raises(UsageError) as caught:
        lamp.value(capability)
    assert str(caught.value).startswith(problem)
    assert lamp.value("vibration") is None


@pytest.mark.parametrize(
    ("own", "others", "expected"),
    [
        ({}, {"battery": 80.0}, 80.0),
        ({"battery": 50.0}, {"battery": 80.0}, 50.0),
        ({"battery": None}, {"battery": 80.0}, None),
        ({}, {"battery": 80.0, "remote": 20.0}, None),
        ({}, {"battery": None}, None),
        ({}, {}, None),
    ],
)
async def test_a_robot_tells_the_battery_of_its_device(
    house: House, own: dict[str, PlainValue], others: dict[str, PlainValue], expected: float | None
) -> None:
    """Its own, where it has one; of two others nobody knows which is the robot's."""
    robot = house.part("robotic_vacuum_cleaner", "vacuum", part_id="robot", reads=own)
    beside = [house.part("x_battery", part_id=one, reads=["battery"], category="diagnostic") for one in others]
    device = house.device("a", robot, *beside, states=own)
    told = [house.state(name, "battery", value) for name, value in others.items()]
    house.has(device.model_copy(update={"states": (*device.states, *told)}))
    (handle,) = await house.devices.find(RoboticVacuumCleaner)
    assert handle.battery == expected


async def test_a_handle_is_always_up_to_date(house: House) -> None:
    """Also its name and routes; what comes late and was told before changes nothing."""
    house.has(house.device("a", house.part("light", "on_off"), on_off=False))
    (lamp,) = await house.devices.find(Light)
    house.says("a", "on_off", True, told_at=5)
    await anyio.sleep(0.01)
    assert lamp.on is True
    house.says("a", "on_off", False, sequence=1)
    house.tells("changed", house.device("a", house.part("light", "on_off"), area="attic", on_off=True))
    await anyio.sleep(0.01)
    assert (lamp.on, lamp.area) == (True, "attic")


async def test_a_removed_device_is_gone_and_comes_back_as_the_same_handle(house: House) -> None:
    """Nothing is sent to it meanwhile."""
    lamp_device = house.device("a", house.part("light", "on_off"))
    house.has(lamp_device)
    (lamp,) = await house.devices.find(Light)
    house.gateway("mqtt")
    house.tells("removed", lamp_device)
    await anyio.sleep(0.01)
    assert lamp.is_gone
    assert isinstance(await lamp.turn_on(), Gone)
    house.tells("appeared", lamp_device)
    await anyio.sleep(0.01)
    assert not lamp.is_gone
    await lamp.turn_on()
    assert house.told == [("mqtt", "", "on_off", True, 0.0)]


Act = Callable[[Any], Awaitable[None]]


@pytest.mark.parametrize(
    ("kind", "settable", "act", "told"),
    [
        (Light, LAMP, lambda it: it.turn_on(), [("on_off", True, 0.0)]),
        (Light, LAMP, lambda it: it.turn_off(transition=2), [("on_off", False, 2.0)]),
        (Light, ("level",), lambda it: it.turn_on(), [("level", 100.0, 0.0)]),
        (Light, ("level",), lambda it: it.turn_off(), [("level", 0.0, 0.0)]),
        (
            Light,
            ("level", "color_temperature"),
            lambda it: it.turn_on(kelvin=2700),
            [("level", 100.0, 0.0), ("color_temperature", 2700.0, 0.0)],
        ),
        (
            Light,
            LAMP,
            lambda it: it.turn_on(level=40, kelvin=2700, transition=1),
            [("level", 40.0, 1.0), ("color_temperature", 2700.0, 1.0)],
        ),
        (
            Light,
            LAMP,
            lambda it: it.turn_on(color=(120, 100), effect="rainbow"),
            [("color", (120.0, 100.0), 0.0), ("effect", "rainbow", 0.0)],
        ),
        (Light, LAMP, lambda it: it.set_level(7), [("level", 7.0, 0.0)]),
        (Light, LAMP, lambda it: it.set_level(0, transition=3), [("on_off", False, 3.0)]),
        (Plug, ("on_off",), lambda it: it.turn_on(), [("on_off", True, 0.0)]),
        (Switch, ("on_off",), lambda it: it.turn_off(), [("on_off", False, 0.0)]),
        (WindowCovering, ("movement", "position"), lambda it: it.open(), [("movement", "open", 0.0)]),
        (WindowCovering, ("position",), lambda it: it.open(), [("position", 100.0, 0.0)]),
        (Closure, ("position",), lambda it: it.close(), [("position", 0.0, 0.0)]),
        (Closure, ("movement", "position"), lambda it: it.close(), [("movement", "closed", 0.0)]),
        (WindowCovering, ("tilt",), lambda it: it.close(), [("tilt", 0.0, 0.0)]),
        (WindowCovering, ("movement",), lambda it: it.stop(), [("movement", "stopped", 0.0)]),
        (WindowCovering, ("position", "tilt"), lambda it: it.set_position(30), [("position", 30.0, 0.0)]),
        (WindowCovering, ("position", "tilt"), lambda it: it.set_tilt(0), [("tilt", 0.0, 0.0)]),
        (DoorLock, ("lock",), lambda it: it.lock(), [("lock", "locked", 0.0)]),
        (DoorLock, ("lock",), lambda it: it.unlock(), [("lock", "unlocked", 0.0)]),
        (DoorLock, ("lock",), lambda it: it.open(), [("lock", "open", 0.0)]),
        (Thermostat, ("heating_setpoint",), lambda it: it.heat_to(21), [("heating_setpoint", 21.0, 0.0)]),
        (AirConditioner, ("cooling_setpoint",), lambda it: it.cool_to(25.5), [("cooling_setpoint", 25.5, 0.0)]),
        (Thermostat, ("thermostat_mode",), lambda it: it.set_mode("auto"), [("thermostat_mode", "auto", 0.0)]),
        (Fan, ("on_off", "fan_speed"), lambda it: it.turn_on(), [("on_off", True, 0.0)]),
        (
            Fan,
            ("on_off", "fan_speed"),
            lambda it: it.turn_on(speed=50),
            [("on_off", True, 0.0), ("fan_speed", 50.0, 0.0)],
        ),
        (Fan, ("fan_speed",), lambda it: it.set_speed(20), [("fan_speed", 20.0, 0.0)]),
        (Fan, ("on_off",), lambda it: it.turn_off(), [("on_off", False, 0.0)]),
        (Fan, ("fan_speed",), lambda it: it.turn_off(), [("fan_speed", 0.0, 0.0)]),
        (Fan, ("on_off", "fan_speed"), lambda it: it.turn_off(), [("on_off", False, 0.0)]),
        (WaterValve, ("valve",), lambda it: it.open(), [("valve", "open", 0.0)]),
        (WaterValve, ("position",), lambda it: it.close(), [("position", 0.0, 0.0)]),
        (WaterValve, ("position",), lambda it: it.set_position(5), [("position", 5.0, 0.0)]),
        (RoboticVacuumCleaner, ("vacuum",), lambda it: it.start(), [("vacuum", "cleaning", 0.0)]),
        (RoboticVacuumCleaner, ("vacuum",), lambda it: it.pause(), [("vacuum", "paused", 0.0)]),
        (RoboticVacuumCleaner, ("vacuum",), lambda it: it.stop(), [("vacuum", "idle", 0.0)]),
        (RoboticVacuumCleaner, ("vacuum",), lambda it: it.return_to_dock(), [("vacuum", "returning", 0.0)]),
        (LawnMower, ("mower",), lambda it: it.start(), [("mower", "mowing", 0.0)]),
        (LawnMower, ("mower",), lambda it: it.pause(), [("mower", "paused", 0.0)]),
        (LawnMower, ("mower",), lambda it: it.return_to_dock(), [("mower", "docked", 0.0)]),
        (MediaPlayer, ("playback",), lambda it: it.play(), [("playback", "playing", 0.0)]),
        (MediaPlayer, ("playback",), lambda it: it.pause(), [("playback", "paused", 0.0)]),
        (MediaPlayer, ("playback",), lambda it: it.stop(), [("playback", "stopped", 0.0)]),
        (MediaPlayer, ("muted",), lambda it: it.mute(), [("muted", True, 0.0)]),
        (MediaPlayer, ("volume",), lambda it: it.set_volume(30), [("volume", 30.0, 0.0)]),
        (Handle, ("volume",), lambda it: it.command("volume", 30), [("volume", 30.0, 0.0)]),
    ],
)
async def test_a_handle_sends_absolute_commands(
    house: House, kind: Any, settable: tuple[str, ...], act: Act, told: list[tuple[str, PlainValue, float]]
) -> None:
    """Through the gateway's service, in the vocabulary's units."""
    service_type = next(iter(kind.service_types), "speaker")
    house.has(house.device("a", house.part(service_type, *settable)))
    house.gateway("mqtt")
    (handle,) = await house.devices.find(kind)
    await act(handle)
    assert house.told == [("mqtt", "", *one) for one in told]


@pytest.mark.parametrize("word", ["OFF", "off", "Off"])
async def test_a_fan_with_a_speed_called_off_is_turned_off_by_that(house: House, word: str) -> None:
    speeds = Capability(name="fan_mode", settable=True, options=("LOW", "HIGH", word))
    house.has(house.device("fan", house.part("fan", capabilities=(speeds,))))
    house.gateway("mqtt")
    (fan,) = await house.devices.find(Fan)
    await fan.turn_off()
    assert house.told == [("mqtt", "", "fan_mode", word, 0.0)]


@pytest.mark.parametrize(
    ("act", "problem"),
    [
        (
            lambda it: it.turn_on(level=40, kelvin=2700),
            "color_temperature of a was refused: it has no such setting; it takes on_off, level, effect, color",
        ),
        (lambda it: it.turn_on(level=0), "0 as level of a was refused: it takes a level above 0 and up to 100 %"),
        (lambda it: it.turn_on(level=float("nan")), "it takes a level above 0 and up to 100 %"),
        (lambda it: it.set_level(101), "101 as level of a was refused: it takes 5 to 100 %"),
        (lambda it: it.set_level(float("inf")), "it takes 5 to 100 %"),
        (lambda it: it.turn_on(level="40"), "'40' as level of a was refused: it takes 5 to 100 %"),
        (lambda it: it.set_level(True), "True as level of a was refused: it takes 5 to 100 %"),
        (lambda it: it.command("level", {}), "{} as level of a was refused: it takes 5 to 100 %"),
        (lambda it: it.command("on_off", "on"), "'on' as on_off of a was refused: it takes True or False"),
        (lambda it: it.turn_on(color=(361, 0)), "(361, 0) as color of a was refused: it takes hue (0 to 360) and sat"),
        (lambda it: it.turn_on(color="red"), "'red' as color of a was refused: it takes hue (0 to 360)"),
        (lambda it: it.turn_on(color=(1,)), "(1,) as color of a was refused: it takes hue (0 to 360)"),
        (lambda it: it.turn_on(transition="2s"), "a transition of '2s' s was refused"),
        (lambda it: it.command("level", 40, code=1234), "it must be a text of 255 characters"),
        (
            lambda it: it.turn_on(transition=-1),
            "a transition of -1 s was refused: it must be a finite number of seconds, 0 or more",
        ),
        (lambda it: it.command("effect", "party"), "'party' as effect of a was refused: it takes rainbow, fire"),
        (
            lambda it: it.command("nonsense", 1),
            "nonsense of a was refused: it has no such setting; it takes on_off, level, effect, color",
        ),
    ],
)
async def test_an_unsupported_command_is_refused_with_the_supported_ones(house: House, act: Act, problem: str) -> None:
    """Before anything is sent, so that no half of a command is done."""
    capabilities = (
        Capability(name="on_off", settable=True),
        Capability(name="level", settable=True, bounds=(5.0, 100.0)),
        Capability(name="effect", settable=True, options=("rainbow", "fire")),
        Capability(name="color", settable=True),
        Capability(name="color_temperature"),
    )
    house.has(house.device("a", house.part("light", capabilities=capabilities)))
    house.gateway("mqtt")
    (lamp,) = await house.devices.find(Light)
    with pytest.raises(RefusedError) as caught:
        await act(lamp)
    assert problem in str(caught.value)
    assert house.told == []


@pytest.mark.parametrize(
    ("service_type", "kind", "capability", "act"),
    [
        ("light", Light, "level", lambda it, share: it.turn_on(level=share)),
        ("light", Light, "level", lambda it, share: it.set_level(share)),
        ("fan", Fan, "fan_speed", lambda it, share: it.turn_on(speed=share)),
        ("fan", Fan, "fan_speed", lambda it, share: it.set_speed(share)),
        ("window_covering", WindowCovering, "position", lambda it, share: it.set_position(share)),
        ("window_covering", WindowCovering, "tilt", lambda it, share: it.set_tilt(share)),
        ("speaker", MediaPlayer, "volume", lambda it, share: it.set_volume(share)),
    ],
)
async def test_a_share_of_one_in_place_of_a_percentage_is_asked_back(
    house: House, service_type: str, kind: Any, capability: str, act: Callable[[Any, float], Awaitable[Outcome]]
) -> None:
    """A lamp at 0.4 % is dark; ``command`` sets it, and so does a computed value, as of a fade or a restored scene."""
    house.has(house.device("a", house.part(service_type, capability)))
    house.gateway("mqtt")
    (handle,) = await house.devices.find(kind)
    for share, percentage in ((0.4, "40"), (0.05, "5"), (0.99, "99")):
        with capture_logs() as lines, pytest.raises(RefusedError) as caught:
            await act(handle, share)
        assert str(caught.value) == (
            f"{share} as {capability} of a was refused: it takes percent; did you mean {percentage} %? "
            f"To set {share} %: command('{capability}', {share})"
        )
        assert house.told == []
        if share == 0.4:
            assert [one["message"] for one in lines if one["event"] == "app.command_failed"] == [f"A: {caught.value}"]
    for value in (1, 1.0, 40, 1.5, 100 / 254):
        await act(handle, value)
    await handle.command(capability, 0.4)
    assert [told[3] for told in house.told] == pytest.approx([1.0, 1.0, 40.0, 1.5, 100 / 254, 0.4])


async def test_a_level_that_a_lamp_cannot_be_turned_on_to_is_logged(house: House) -> None:
    """In a handler nobody saw the error."""
    house.has(house.device("a", house.part("light", "level")))
    (lamp,) = await house.devices.find(Light)
    with capture_logs() as lines, pytest.raises(RefusedError):
        await lamp.turn_on(level=150)
    assert [one["message"] for one in lines if one["event"] == "app.command_failed"] == [
        "A: 150 as level of a was refused: it takes a level above 0 and up to 100 %"
    ]


async def test_a_sensor_takes_no_commands(house: House) -> None:
    """And says so."""
    house.has(house.device("a", house.part("contact_sensor", reads=["contact"])))
    (contact,) = await house.devices.find(ContactSensor)
    with pytest.raises(RefusedError, match="contact of a was refused: it takes no commands"):
        await contact.command("contact", True)


async def test_a_command_goes_by_the_first_gateway_that_is_there(house: House) -> None:
    """And by the next one when that has no link; never by two."""
    house.has(house.device("a", house.part("plug", "on_off", gateways=["native", "other"])))
    (plug,) = await house.devices.find(Plug)
    assert "on_off of a: its gateway native is not running" in (await plug.turn_on()).text
    house.gateway("other")
    await plug.turn_on()
    native = house.gateway("native")
    await plug.turn_off()
    house.answers["native"] = SendCommandResponse(success=False, message="no link", problem="unreachable")
    await plug.turn_on()
    house.answers["other"] = house.answers["native"]
    assert "on_off of a: no link" in (await plug.turn_on()).text
    native.close()
    assert [(one[0], one[3]) for one in house.told] == [("other", True), ("native", False), ("other", True)]


async def test_a_gateway_that_refuses_is_not_asked_twice(house: House) -> None:
    """The same again by another way would only be refused again, or do what shall not be done."""
    house.has(house.device("a", house.part("plug", "on_off", gateways=["native", "other"])))
    house.gateway("native")
    house.gateway("other")
    house.answers["native"] = SendCommandResponse(success=False, message="it only observes", problem="refused")
    (plug,) = await house.devices.find(Plug)
    assert "on_off of a was refused: it only observes" in (await plug.turn_on()).text
    assert house.told == []


async def test_a_disputed_part_is_told_nothing(house: House) -> None:
    """It has no way, and the device says why."""
    disputed = house.device("a", house.part("plug", "on_off", gateways=[]))
    house.has(disputed.model_copy(update={"conflicts": ("mqtt:b claims home/a/set",)}))
    (plug,) = await house.devices.find(Plug)
    assert "a command to a was refused: mqtt:b claims home/a/set" in (await plug.turn_on()).text


async def test_a_device_without_parts_has_no_handle(house: House) -> None:
    """Nobody knows what there would be to read and tell."""
    house.has(house.device("a", word="coffee"), house.device("b", word="lights"))
    assert await house.devices.find(Handle) == ()


async def test_without_a_directory_nothing_is_found_and_said(house: House) -> None:
    """As for devices by word."""
    house.end_directory()
    with pytest.raises(ServiceUnavailableError):
        await house.devices.find(Light)


async def test_a_gateway_that_fails_is_a_link_that_is_not_there(house: House) -> None:
    """Whatever its fault is, the next way is tried; whether it acted is unknown, so commands are absolute."""
    house.has(house.device("a", house.part("plug", "on_off", gateways=["native", "other"])))
    house.gateway("native")
    house.failing.add("native")
    (plug,) = await house.devices.find(Plug)
    assert "on_off of a: service /gateway/native/send_command failed: " in (await plug.turn_on()).text
    house.gateway("other")
    await plug.turn_on()
    assert [one[0] for one in house.told] == ["other"]


async def test_the_handles_of_a_device_are_there_without_a_directory(house: House) -> None:
    """They are kept up to date like all others."""
    wall = house.device(
        "wall", house.part("switch", "on_off", part_id="a"), house.part("switch", "on_off", part_id="b")
    )
    house.has(wall)
    left, right = house.devices.handles(wall, Switch)
    assert [left.id, right.id, right.part_id] == ["wall#a", "wall#b", "b"]
    assert house.devices.handles(wall, Light) == ()
    house.says("wall", "on_off", value=True, part_id="b")
    await anyio.sleep(0.01)
    assert (left.on, right.on) == (None, True)


@pytest.mark.parametrize(
    ("kind", "capability", "act", "value"),
    [
        (AlarmPanel, "alarm", lambda it, code: it.disarm(code=code), "disarmed"),
        (AlarmPanel, "alarm", lambda it, code: it.arm_home(code=code), "armed_home"),
        (AlarmPanel, "alarm", lambda it, code: it.arm_away(code=code), "armed_away"),
        (AlarmPanel, "alarm", lambda it, code: it.arm_night(code=code), "armed_night"),
        (AlarmPanel, "alarm", lambda it, code: it.arm_vacation(code=code), "armed_vacation"),
        (AlarmPanel, "alarm", lambda it, code: it.arm_custom_bypass(code=code), "armed_custom_bypass"),
        (AlarmPanel, "alarm", lambda it, code: it.trigger(code=code), "triggered"),
        (DoorLock, "lock", lambda it, code: it.lock(code=code), "locked"),
        (DoorLock, "lock", lambda it, code: it.unlock(code=code), "unlocked"),
        (DoorLock, "lock", lambda it, code: it.open(code=code), "open"),
        (Handle, "alarm", lambda it, code: it.command("alarm", "disarmed", code=code), "disarmed"),
    ],
)
async def test_a_code_goes_with_the_command(house: House, kind: Any, capability: str, act: Any, value: str) -> None:
    service_type = next(iter(kind.service_types), "x_alarm_panel")
    house.has(house.device("a", house.part(service_type, capability)))
    house.gateway("mqtt")
    (handle,) = await house.devices.find(kind)
    await act(handle, "1234")
    await act(handle, "")
    assert house.told == [("mqtt", "", capability, value, 0.0)] * 2
    assert house.codes == ["1234", ""]
    with pytest.raises(RefusedError, match="it must be a text of 255 characters") as refused:
        await act(handle, "7355" * 64)
    assert "7355" not in str(refused.value)


@pytest.mark.parametrize(
    ("state", "armed"),
    [("armed_away", True), ("triggered", True), ("disarmed", False), ("pending", None), ("arming", None), (None, None)],
)
async def test_an_alarm_tells_whether_it_is_armed(house: House, state: str | None, armed: bool | None) -> None:  # noqa: FBT001
    house.has(house.device("a", house.part("x_alarm_panel", "alarm"), states={"alarm": state}))
    (panel,) = await house.devices.find(AlarmPanel)
    assert (panel.state, panel.armed) == (state, armed)
