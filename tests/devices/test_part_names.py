"""Names for people of devices and of their parts."""

from homebot.control.command import label_of
from homebot.devices import Device, DevicePart
from homebot.devices.device import part_names
from homebot.devices.part import Capability, Category, Part
from homebot.messages import Time
from homebot.words.suitable_parts import part_name


def part(part_id: str, name: str = "", *, settable: bool = True, category: Category = "") -> DevicePart:
    switch = Capability(name="on_off", settable=settable)
    described = Part(id=part_id, name=name, service_type="switch", category=category, capabilities=(switch,))
    return DevicePart(id=part_id, part=described, routes=())


def device(*parts: DevicePart) -> Device:
    now = Time.from_seconds(1.0)
    return Device(
        id="relays",
        name="Relays",
        service_type="switch",
        endpoints=(),
        metadata=(),
        first_seen=now,
        last_seen=now,
        expires=now,
        freshness="fresh",
        parts=parts,
    )


def test_each_of_two_relays_has_a_name() -> None:
    """Its own after that of the device, else its id; none where it has neither."""
    relays = device(part("r1", "left"), part("r2"), part(""))
    assert part_names([relays]) == {
        "relays": "Relays",
        "relays#r1": "Relays left",
        "relays#r2": "Relays r2",
        "relays#": "Relays",
    }


def test_one_relay_beside_a_meter_and_a_setting_is_called_as_its_device() -> None:
    relay = device(part("r1", "left"), part("power", settable=False), part("led", category="config"))
    assert part_names([relay]) == {"relays": "Relays"}
    assert label_of(relay, "r1") == "relays"
    assert label_of(relay, "led") == "relays#led"


def test_a_lone_relay_beside_a_setting_is_called_as_its_device_by_commands_too() -> None:
    lone, setting, meter = part("r1", "left"), part("led", "LED", category="config"), part("power", "Power")
    assert part_name(device(lone, setting), lone) == "Relays"
    assert part_name(device(lone, setting), setting) == "Relays LED"
    assert part_name(device(lone, setting, meter), lone) == "Relays left"
