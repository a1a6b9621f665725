"""Devices of simulated houses, understood by the conventions that real devices are understood by."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import pytest

from homebot.conventions.convention import Convention
from homebot.conventions.description import DescribedPart, DeviceAnnounced, DeviceRequest, Publication
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.house.devices import (
    CoverMotor,
    SimulatedDoorLock,
    SimulatedLamp,
    SimulatedLift,
    SimulatedThermostat,
    WindowMotor,
)
from homebot.house.dialect import Dialect, OutgoingMessage, SimulatedDeviceInfo, state_of
from homebot.house.family import dialects
from homebot.house.sensors import LuxSensor, MotionSensor, PowerMeter, PresenceSensor, SimulatedContactSensor
from homebot.house.simulated_device import SimulatedDevice
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.integrations.homie.formats import Homie, HomieSettings
from homebot.integrations.shelly.formats import Shelly, ShellySettings
from homebot.integrations.tasmota.formats import TasmotaDiscovery, TasmotaSettings
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings
from homebot.mqtt.topics import topic_matches

CONVENTIONS: Mapping[str, Callable[[], Convention]] = {
    "homeassistant": lambda: HomeAssistantDiscovery(HomeAssistantSettings()),
    "homeassistant_device": lambda: HomeAssistantDiscovery(HomeAssistantSettings()),
    "zigbee2mqtt": lambda: Zigbee2Mqtt(Zigbee2MqttSettings()),
    "tasmota": lambda: TasmotaDiscovery(TasmotaSettings()),
    "shelly": lambda: Shelly(ShellySettings()),
    "shelly_rpc": lambda: Shelly(ShellySettings()),
    "homie": lambda: Homie(HomieSettings()),
}
KINDS: Mapping[str, Callable[[], SimulatedDevice]] = {
    "lamp": lambda: SimulatedLamp("desk"),
    "window": lambda: WindowMotor("desk"),
    "cover": lambda: CoverMotor("desk"),
    "lock": lambda: SimulatedDoorLock("desk"),
    "lift": lambda: SimulatedLift("desk"),
    "contact": lambda: SimulatedContactSensor("desk"),
    "motion": lambda: MotionSensor("desk"),
    "presence": lambda: PresenceSensor("desk"),
    "lux": lambda: LuxSensor("desk"),
    "power_meter": lambda: PowerMeter("desk"),
    "thermostat": lambda: SimulatedThermostat("desk"),
}


@dataclass
class Bench:
    """One device on one side, its convention on the other, and nothing between them but topics and payloads."""

    dialect: Dialect
    device: SimulatedDevice
    plate: SimulatedDeviceInfo
    described: list[DeviceAnnounced]

    @property
    def parts(self) -> list[DescribedPart]:
        return [part for one in self.described for part in one.parts]

    def hear(self) -> dict[str, PlainValue]:
        """What is understood of all that the device says of itself now."""
        condition = state_of(self.device, self.device.state())
        return self.understood(self.dialect.state_messages(self.plate, condition))

    def understood(self, messages: tuple[OutgoingMessage, ...]) -> dict[str, PlainValue]:
        told: dict[str, PlainValue] = {}
        for message in messages:
            for part in self.parts:
                if any(topic_matches(one, message.topic) for one in part.codec.topics()):
                    told |= part.codec.read(message.topic, message.payload, retained=False)
        return told

    def tell(self, capability: str, value: PlainValue) -> None:
        """Write, send what can be heard, obey, and let it come to rest."""
        for publication in self.written(capability, value):
            assert any(topic_matches(one, publication.topic) for one in self.dialect.filters(self.plate))
            for word in self.dialect.parse_command(self.plate, publication.topic, publication.payload):
                self.device.handle_command(word, self.device.now)
        self.device.advance(self.device.now + 60.0)

    def written(self, capability: str, value: PlainValue) -> tuple[Publication, ...]:
        for part in self.parts:
            try:
                return part.codec.write(capability, value)
            except RefusedError:
                continue
        raise AssertionError(f"no part takes {capability}")


def bench(name: str, kind: str) -> Bench:
    """Let the device be born, and answer what its convention asks it."""
    dialect, device, convention = dialects()[name], KINDS[kind](), CONVENTIONS[name]()
    plate = SimulatedDeviceInfo("villa", kind, device.device_id, device.service_type, "study", device.commands())
    bridge = dialect.bridge([plate])
    ahead = [*(bridge.birth if bridge else ()), *dialect.birth(plate)]
    described: dict[str, DeviceAnnounced] = {}
    while ahead:
        message = ahead.pop(0)
        if not any(topic_matches(one, message.topic) for one in convention.filters()):
            continue
        for heard in convention.read_message(message.topic, message.payload, retained=message.retain):
            if isinstance(heard, DeviceAnnounced):
                described[heard.key] = heard
            elif isinstance(heard, DeviceRequest):
                for asked in heard.publications:
                    condition = state_of(device, device.state())
                    ahead += dialect.replies(plate, condition, asked.topic, asked.payload)
    for one in described.values():
        assert one.identifiers
    return Bench(dialect, device, plate, list(described.values()))


def pairs(kind: str | None = None) -> list[tuple[str, str]]:
    return [(name, one) for name in CONVENTIONS for one in sorted(dialects()[name].kinds) if kind in {None, one}]


TYPES = {
    "lamp": {"light"},
    "window": {"closure", "window_covering"},
    "cover": {"window_covering"},
    "lock": {"door_lock"},
    "lift": {"x_lift"},
    "contact": {"contact_sensor", "x_binary_sensor"},
    "motion": {"occupancy_sensor", "x_binary_sensor"},
    "presence": {"occupancy_sensor"},
    "lux": {"light_sensor"},
    "power_meter": {"electrical_meter"},
    "thermostat": {"thermostat"},
}
"""What it may be taken for: Tasmota does not say what its switches are for, and only discovery knows windows."""


@pytest.mark.parametrize(("name", "kind"), pairs())
def test_a_device_has_the_type_of_its_parts(name: str, kind: str) -> None:
    """By what it announces alone."""
    assert TYPES[kind] & {part.part.service_type for part in bench(name, kind).parts}


@pytest.mark.parametrize(("name", "kind"), pairs())
def test_birth_and_will_report_availability(name: str, kind: str) -> None:
    """Shelly's contacts run on batteries and are asleep most of the time, which is no bad sign."""
    there = bench(name, kind)
    (described,) = there.described
    if (name, kind) == ("shelly", "contact"):
        assert described.availability is None
        return
    assert described.availability is not None
    will = there.dialect.will(there.plate)
    assert will is not None
    (source,) = [one for one in described.availability.sources if one.topic == will.topic]
    births = [one for one in there.dialect.birth(there.plate) if one.topic == will.topic]
    assert (source.read(births[-1].payload), source.read(will.payload)) == (True, False)


@pytest.mark.parametrize(("name", "kind"), pairs("lamp"))
def test_a_lamp_reports_and_obeys(name: str, kind: str) -> None:
    """On, off, and as bright as told."""
    lamp = bench(name, kind)
    assert lamp.hear()["on_off"] is False
    lamp.tell("on_off", value=True)
    assert (lamp.device.state(), lamp.hear()["on_off"]) == ("on", True)
    lamp.tell("level", 40.0)
    assert lamp.device.watts() == pytest.approx(0.4 * 9.0, abs=0.05)
    assert lamp.hear()["level"] == pytest.approx(40.0, abs=0.5)
    lamp.tell("on_off", value=False)
    assert (lamp.device.state(), lamp.hear()["on_off"]) == ("off", False)


@pytest.mark.parametrize("name", [name for name in CONVENTIONS if name != "shelly_rpc"])
def test_a_lamp_has_the_commanded_colour_temperature(name: str) -> None:
    """All of these families but one have lamps with warm and cold light."""
    lamp = bench(name, "lamp")
    lamp.tell("color_temperature", 4000.0)
    assert lamp.hear()["color_temperature"] == pytest.approx(4000.0, abs=20.0)


@pytest.mark.parametrize(("name", "kind"), [*pairs("cover"), *pairs("window")])
def test_a_motor_moves_to_the_commanded_position(name: str, kind: str) -> None:
    """And says where it is, and while it goes."""
    motor = bench(name, kind)
    motor.tell("movement", "open")
    opened = motor.hear()
    assert opened["position"] == 100.0
    motor.tell("position", 30.0)
    assert motor.hear()["position"] == 30.0
    for publication in motor.written("movement", "closed"):
        for word in motor.dialect.parse_command(motor.plate, publication.topic, publication.payload):
            motor.device.handle_command(word, motor.device.now)
    assert motor.device.state() == "closing"
    motor.device.advance(motor.device.now + 60.0)
    told = motor.hear()
    assert (told["position"], told.get("movement")) == (0.0, "closed" if "movement" in opened else None)


@pytest.mark.parametrize(("name", "kind"), pairs("lock"))
def test_a_lock_reports_and_obeys(name: str, kind: str) -> None:
    lock = bench(name, kind)
    assert lock.hear()["lock"] == "locked"
    lock.tell("lock", "unlocked")
    assert (lock.device.state(), lock.hear()["lock"]) == ("unlocked", "unlocked")


@pytest.mark.parametrize(("name", "kind"), pairs("lift"))
def test_a_lift_goes_to_a_floor_with_a_closed_door(name: str, kind: str) -> None:
    lift = bench(name, kind)
    assert lift.hear() == {"floor": "ground", "movement": "closed"}
    lift.tell("movement", "open")
    lift.tell("floor", "upper")
    assert lift.hear() == {"floor": "ground", "movement": "open"}
    lift.tell("movement", "closed")
    lift.tell("floor", "upper")
    assert lift.hear() == {"floor": "upper", "movement": "closed"}


@pytest.mark.parametrize(("name", "kind"), pairs("thermostat"))
def test_a_thermostat_reports_and_obeys(name: str, kind: str) -> None:
    thermostat = bench(name, kind)
    thermostat.tell("heating_setpoint", 23.5)
    told = thermostat.hear()
    assert told["heating_setpoint"] == 23.5
    assert {told.get("local_temperature"), told.get("temperature")} & {20.0}


@pytest.mark.parametrize(
    ("kind", "felt", "names", "value"),
    [
        ("contact", 1.0, {"contact", "state"}, True),
        ("motion", 2.0, {"occupancy", "state"}, True),
        ("lux", 250.0, {"illuminance"}, 250.0),
        ("power_meter", 60.0, {"power"}, 60.0),
    ],
)
@pytest.mark.parametrize("name", CONVENTIONS)
def test_a_sensor_reports_its_measurement(
    name: str, kind: str, felt: float, names: set[str], value: PlainValue
) -> None:
    """In canonical units; an open door is open, whichever way round the wire has it."""
    if kind not in dialects()[name].kinds:
        assert name in {"tasmota", "shelly", "shelly_rpc"}
        return
    sensor = bench(name, kind)
    sensor.device.apply_input(felt, 1.0)
    assert [told for one, told in sensor.hear().items() if one in names] == [value]


@pytest.mark.parametrize("name", ["zigbee2mqtt", "tasmota", "shelly"])
def test_a_device_without_retained_state_reports_on_request(name: str) -> None:
    """As conventions ask once they listen."""
    lamp = bench(name, "lamp")
    asked = [one for part in lamp.parts for one in part.state_requests]
    condition = state_of(lamp.device, "on")
    answers = [lamp.dialect.replies(lamp.plate, condition, one.topic, one.payload) for one in asked]
    assert any(lamp.understood(one).get("on_off") is True for one in answers)
