"""HomeKit accessories of a simulated house, as homebot finds them: by other people's code at both ends."""

from collections.abc import Mapping

import pytest
from tests.house.onlooker import found, house
from tests.integrations.homekit.simulated.bridge import SERVICES, VALUES, orders_of
from tests.loopback import alone_on_loopback
from tests.simulated.families import FAMILIES

from homebot.devices import Devices
from homebot.devices.always_ask import always_asks
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed
from homebot.devices.value import PlainValue
from homebot.house.dialect import DeviceState


@pytest.mark.slow
async def test_each_kind_is_a_device_and_a_lamp_obeys() -> None:
    tables = {kind: {"kind": kind, "dialect": FAMILIES["homekit"]} for kind in SERVICES}
    async with alone_on_loopback(), house(tables) as (node, world):
        devices = await found(node, *SERVICES)
        types = {kind: devices[kind].parts[0].part.service_type for kind in SERVICES}
        bridges = [one for one in await Devices(node).find() if "homekit" in {end.gateway for end in one.endpoints}]
        asks = {kind for kind in SERVICES if any(always_asks(devices[kind], one) for one in devices[kind].parts)}
        (lamp,) = await Devices(node).find(Light)
        outcome = await lamp.turn_on()
        assert (type(outcome), world.device("lamp").state()) == (Confirmed, "on")
    assert asks == {"lock", "window"}
    (bridge,) = (one for one in bridges if not one.parts)
    assert {one.gateway for one in bridge.endpoints} == {"homekit", "mdns"}
    assert types == {
        "lamp": "light",
        "window": "closure",
        "cover": "window_covering",
        "lock": "door_lock",
        "contact": "contact_sensor",
        "motion": "occupancy_sensor",
        "lux": "light_sensor",
        "thermostat": "thermostat",
    }


@pytest.mark.parametrize(
    ("kind", "state", "values"),
    [
        ("lamp", DeviceState(text="on", is_on=True, brightness=0.4, kelvin=2500.0),
         {"On": True, "Brightness": 40, "ColorTemperature": 400}),
        ("cover", DeviceState(text="closing", position=0.3, way=-1), {"CurrentPosition": 30, "PositionState": 0}),
        ("lock", DeviceState(text="locked"), {"LockCurrentState": 1, "LockTargetState": 1}),
        ("contact", DeviceState(text="open"), {"ContactSensorState": 1}),
        ("motion", DeviceState(text="motion"), {"MotionDetected": True}),
        ("lux", DeviceState(text="0", value=0.0), {"CurrentAmbientLightLevel": 0.0001}),
    ],
)  # fmt: skip
def test_a_state_is_the_values_of_characteristics(
    kind: str, state: DeviceState, values: Mapping[str, PlainValue]
) -> None:
    assert VALUES[kind](state) == values


@pytest.mark.parametrize(
    ("kind", "values", "orders"),
    [
        ("lamp", {"On": 1}, ("on",)),
        ("lamp", {"On": 0}, ("off",)),
        ("lamp", {"Brightness": 40, "On": 1}, ("0.4",)),
        ("cover", {"TargetPosition": 30}, ("0.3",)),
        ("window", {"HoldPosition": 1}, ("stop",)),
        ("lock", {"LockTargetState": 0}, ("unlock",)),
        ("thermostat", {"TargetTemperature": 21.5}, ("21.5",)),
    ],
)
def test_written_characteristics_are_orders(kind: str, values: Mapping[str, float], orders: tuple[str, ...]) -> None:
    assert orders_of(kind, values) == orders
