"""Two messages of a device in, one description out: in any order, bounded, and gone when emptied."""

import json
from typing import Any

import pytest
from tests.integrations.announced_parts import device_in

from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced, DeviceWithdrawn, LastWillAvailability
from homebot.conventions.unreadable import FOUND
from homebot.errors import WireError
from homebot.integrations.tasmota.formats import TasmotaDiscovery, TasmotaSettings
from homebot.integrations.tasmota.formats.reader import MAX_DEVICES, MAX_WAITING

MAC = "2462AB000011"
SENSORS = {"sn": {"DS18B20": {"Id": "01", "Temperature": 21.5}, "TempUnit": "C"}, "ver": 1}


def config(mac: str = MAC, **more: Any) -> dict[str, Any]:
    return {
        "ver": 1,
        "mac": mac,
        "dn": "Kitchen plug",
        "fn": ["Kitchen plug", None],
        "hn": "tasmota-000011-17",
        "md": "Sonoff Basic",
        "sw": "14.4.1",
        "ip": "192.168.1.10",
        "ft": "%prefix%/%topic%/",
        "t": "tasmota_000011",
        "tp": ["cmnd", "stat", "tele"],
        "state": ["OFF", "ON", "TOGGLE", "HOLD"],
        "onln": "Online",
        "ofln": "Offline",
        "rl": [1, 0],
        **more,
    }


def discovery(prefix: str = "tasmota/discovery") -> TasmotaDiscovery:
    return TasmotaDiscovery(TasmotaSettings(prefix=prefix))


def take(convention: TasmotaDiscovery, kind: str, fields: object, mac: str = MAC) -> tuple[AnnouncementEvent, ...]:
    payload = b"" if fields is None else json.dumps(fields).encode()
    return convention.read_message(f"tasmota/discovery/{mac}/{kind}", payload, retained=True)


def ids(device: DeviceAnnounced) -> list[str]:
    return [part.part.id for part in device.parts]


def test_it_listens_to_both_messages_of_each_device() -> None:
    assert discovery("t/d").filters() == ("t/d/+/config", "t/d/+/sensors")
    assert discovery().birth_messages() == ()


def test_a_device_is_described_with_its_address_topics_and_facts() -> None:
    device = device_in(take(discovery(), "config", config()))
    assert (device.key, device.name, device.identifiers) == (MAC, "Kitchen plug", ("mac:2462ab000011",))
    assert device.facts == {
        "manufacturer": "Tasmota",
        "model": "Sonoff Basic",
        "sw_version": "14.4.1",
        "hostname": "tasmota-000011-17",
        "ip": "192.168.1.10",
    }
    relay = device.parts[0].part
    assert (relay.id, relay.service_type, relay.name) == ("power_1", "switch", "")
    assert relay.reads == ("stat/tasmota_000011/RESULT", "tele/tasmota_000011/STATE")
    assert relay.writes == ("cmnd/tasmota_000011/Power1",)


def test_an_address_of_digits_alone_is_an_address() -> None:
    assert device_in(take(discovery(), "config", config("240000000011"), "240000000011")).identifiers == (
        "mac:240000000011",
    )


@pytest.mark.parametrize(
    ("full_topic", "expected"),
    [
        ("%topic%/%prefix%/", "tasmota_000011/cmnd/Power1"),
        ("home/%hostname%/%prefix%/%id%/", f"home/tasmota-000011-17/cmnd/{MAC}/Power1"),
        ("%prefix%/home/%topic%", "cmnd/home/tasmota_000011/Power1"),
        ("home//#%topic%", "home/tasmota_000011/cmnd/Power1"),
    ],
)
def test_topics_are_made_as_the_device_was_set_up(full_topic: str, expected: str) -> None:
    assert device_in(take(discovery(), "config", config(ft=full_topic))).parts[0].part.writes == (expected,)


@pytest.mark.parametrize(
    ("topics", "own"),
    [
        ({}, ("cmnd/tasmota_000011",)),
        ({"t": "tasmota_%06X", "ft": "%id%/%topic%/%prefix%/"}, ("2462AB000011/tasmota_%06X/cmnd",)),
        ({"t": "door"}, ()),
    ],
)
def test_the_topics_with_its_address_are_the_device_s_own(topics: dict[str, str], own: tuple[str, ...]) -> None:
    """No lamp switches it there in other words, such as ``POWER1`` or ``Backlog``; any name could be in a config."""
    assert device_in(take(discovery(), "config", config(**topics))).owns == ("cmnd/DVES_000011_fb", *own)


def test_sensors_come_after_the_config() -> None:
    convention = discovery()
    assert ids(device_in(take(convention, "config", config()))) == ["power_1", "wifi"]
    assert ids(device_in(take(convention, "sensors", SENSORS))) == [
        "power_1",
        "DS18B20_Temperature",
        "DS18B20_Id",
        "wifi",
    ]
    assert take(convention, "sensors", SENSORS) == ()


def test_sensors_come_before_the_config() -> None:
    convention = discovery()
    assert take(convention, "sensors", SENSORS) == ()
    assert "DS18B20_Temperature" in ids(device_in(take(convention, "config", config())))
    assert "DS18B20_Temperature" in ids(device_in(take(convention, "config", config())))


def test_an_unchanged_config_gives_the_same_description() -> None:
    convention = discovery()
    device = device_in(take(convention, "config", config()))
    assert device_in(take(convention, "config", config())) is device
    assert device_in(take(convention, "config", config(dn="Plug"))).name == "Plug"


def test_sensors_that_are_removed_leave_the_rest() -> None:
    convention = discovery()
    take(convention, "config", config())
    take(convention, "sensors", SENSORS)
    assert ids(device_in(take(convention, "sensors", None))) == ["power_1", "wifi"]


def test_a_config_that_is_removed_withdraws_the_device() -> None:
    convention = discovery()
    assert take(convention, "config", None) == ()
    take(convention, "config", config())
    assert take(convention, "config", None) == (DeviceWithdrawn(MAC, "its config was removed"),)
    assert take(convention, "sensors", SENSORS) == ()


def test_the_oldest_that_waits_is_forgotten_and_counted() -> None:
    convention = discovery()
    for number in range(MAX_WAITING + 1):
        take(convention, "sensors", SENSORS, f"{number:012X}")
    assert convention.reader.forgotten == 1
    assert "DS18B20_Id" not in ids(device_in(take(convention, "config", config("0" * 12), "0" * 12)))
    last = f"{MAX_WAITING:012X}"
    assert "DS18B20_Id" in ids(device_in(take(convention, "config", config(last), last)))


def test_one_device_too_many_is_refused() -> None:
    convention = discovery()
    for number in range(MAX_DEVICES):
        mac = f"{number:012X}"
        take(convention, "config", config(mac, rl=[]), mac)
    with pytest.raises(WireError, match="exceeds the limit of 5000 devices"):
        take(convention, "config", config())
    assert device_in(take(convention, "config", config("0" * 12), "0" * 12)).key == "0" * 12


@pytest.mark.parametrize(
    "change",
    [
        {"ver": 2},
        {"mac": "2462AB000012"},
        {"ft": 1},
        {"ft": "%prefix%/+/"},
        {"t": "a\x00", "ft": "%topic%/"},
        {"tp": ["cmnd", "stat"]},
        {"tp": ["cmnd", "", "tele"]},
        {"rl": None},
        {"rl": [1] * 1_000},
    ],
    ids=str,
)
def test_a_config_that_cannot_be_used_is_refused_and_counted(change: dict[str, Any]) -> None:
    convention = discovery()
    with pytest.raises(WireError) as refused:
        take(convention, "config", config(**change))
    assert convention.rejected == 1
    assert len(str(refused.value)) < 400


def test_other_topics_say_nothing() -> None:
    convention = discovery()
    for topic in (f"tasmota/{MAC}/config", f"{MAC}/config", "tasmota/discovery/lamp/config", f"{MAC}/x"):
        assert convention.read_message(topic, b"{}", retained=True) == ()


def test_the_last_will_reports_availability() -> None:
    availability = device_in(take(discovery(), "config", config(onln="Da", ofln="Weg"))).availability
    assert availability is not None
    (will,) = availability.sources
    assert will == LastWillAvailability("tele/tasmota_000011/LWT", b"Da", b"Weg")
    assert [will.read(word) for word in (b"Da", b"Weg", b"Online")] == [True, False, None]


def test_a_sleeper_has_no_last_will_and_is_not_asked() -> None:
    device = device_in(take(discovery(), "config", config(dslp=1)))
    assert device.availability is None
    assert [part.state_requests for part in device.parts] == [(), ()]


def bus(*temperatures: float, name: str = "DS18B20", sign: str = "-") -> dict[str, Any]:
    """Probes whose addresses are their temperatures: Tasmota numbers them in order, unless there is only one."""
    numbered = {f"{name}{sign}{number}": one for number, one in enumerate(sorted(temperatures), 1)}
    named = {name: temperatures[0]} if len(temperatures) == 1 else numbered
    return {**{one: {"Id": f"3C{of:06.1f}", "Temperature": of} for one, of in named.items()}, "TempUnit": "C"}


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ((20.0, 60.0), (5.0, 20.0, 60.0), {"DS18B20-1": 20.0, "DS18B20-2": 60.0, "DS18B20-3C0005.0": 5.0}),
        ((20.0, 60.0), (20.0, 30.0, 60.0), {"DS18B20-1": 20.0, "DS18B20-2": 60.0, "DS18B20-3C0030.0": 30.0}),
        ((20.0, 60.0), (20.0, 60.0, 70.0), {"DS18B20-1": 20.0, "DS18B20-2": 60.0, "DS18B20-3": 70.0}),
        ((20.0, 60.0, 70.0), (60.0, 70.0), {"DS18B20-2": 60.0, "DS18B20-3": 70.0}),  # one fails
        ((20.0, 60.0), (60.0,), {"DS18B20-2": 60.0}),
        ((20.0,), (5.0, 20.0), {"DS18B20": 20.0, "DS18B20-1": 5.0}),
        ((20.0, 60.0), (10.0, 60.0), {"DS18B20-3C0010.0": 10.0, "DS18B20-2": 60.0}),  # one is replaced
    ],
)
@pytest.mark.parametrize("sign", ["-", "_"])
def test_a_probe_on_a_bus_keeps_its_part_when_others_come_or_go(
    before: tuple[float, ...], after: tuple[float, ...], expected: dict[str, float], sign: str
) -> None:
    convention = discovery()
    take(convention, "config", config())
    take(convention, "sensors", {"sn": bus(*before, sign=sign), "ver": 1})
    taken = take(convention, "sensors", {"sn": bus(*after, sign=sign), "ver": 1})
    told = json.dumps({"Time": "now", **bus(*after, sign=sign)}).encode()
    read = {
        part.part.id: part.codec.read("tele/tasmota_000011/SENSOR", told, retained=False).get("temperature")
        for part in device_in(taken).parts
        if part.part.id.endswith("_Temperature")
    }
    known = {one.replace("-3C", "#").replace("-", sign).replace("#", "-3C"): of for one, of in expected.items()}
    assert read == {f"{one}_Temperature": of for one, of in known.items()}


def test_a_message_with_new_numbers_is_read_by_addresses_before_it_is_announced() -> None:
    convention = discovery()
    take(convention, "config", config())
    (first, *_) = device_in(take(convention, "sensors", {"sn": bus(20.0, 60.0), "ver": 1})).parts[1:]
    assert first.part.id == "DS18B20-1_Temperature"
    told = json.dumps(bus(5.0, 20.0, 60.0)).encode()
    assert first.codec.read("tele/tasmota_000011/SENSOR", told, retained=False) == {"temperature": 20.0}


@pytest.mark.parametrize(
    ("name", "unit", "told", "expected"),
    [
        ("DS18B20", "C", 85.0, None),
        ("DS18B20-1", "C", -127.0, None),
        ("DS18S20", "F", 185.0, None),
        ("DS1822", "F", -196.6, None),
        ("DS18B20", "C", 84.9, 84.9),
        ("MAX31855", "C", 85.0, 85.0),
        ("BME280", "F", 185.0, 85.0),
    ],
)
def test_only_the_known_errors_of_a_probe_are_no_readings(
    name: str, unit: str, told: float, expected: float | None
) -> None:
    convention = discovery()
    take(convention, "config", config())
    message = {name: {"Temperature": told}, "TempUnit": unit}
    parts = device_in(take(convention, "sensors", {"sn": message, "ver": 1})).parts
    (codec,) = (part.codec for part in parts if part.part.id == f"{name}_Temperature")
    FOUND.clear()
    read = codec.read("tele/tasmota_000011/SENSOR", json.dumps(message).encode(), retained=False)
    assert read.get("temperature") == (None if expected is None else pytest.approx(expected))
    assert [one.why().split(": ")[0] for one in FOUND] == (["85" if told > 0 else "-127"] if expected is None else [])
    FOUND.clear()
