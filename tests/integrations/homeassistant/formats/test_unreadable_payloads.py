"""Payloads that no reader of a part understands are counted and reported with the reason, and normal ones are not."""

import json
from collections.abc import Mapping
from typing import Final

import anyio
import pytest
from structlog.testing import capture_logs
from tests.gateways.mqtt.simple_house import House, simple_house
from tests.whole_house import WHOLE_HOUSE

pytestmark = pytest.mark.virtual_time

HA: Final = ("homeassistant",)
TOPIC: Final = "t"
FIELDS: Final[Mapping[str, Mapping[str, object]]] = {
    "alarm_control_panel": {"command_topic": "c"},
    "climate": {"modes": ["off", "heat"], "mode_state_topic": TOPIC, "mode_command_topic": "c"},
    "cover": {"command_topic": "c"},
    "event": {"event_types": ["press", "hold"]},
    "lock": {"command_topic": "c"},
    "number": {"command_topic": "c", "min": 1, "max": 10},
    "select": {"command_topic": "c", "options": ["a", "b"]},
    "switch": {"command_topic": "c"},
}


async def announce(house: House, component: str, **fields: object) -> None:
    config = {"name": "W", "unique_id": "w", "state_topic": TOPIC, **FIELDS.get(component, {}), **fields}
    await house.say(f"homeassistant/{component}/w/config", config)


async def unreadable(house: House, *payloads: str | bytes, retain: bool = False) -> list[str]:
    """Return what was reported of *payloads*, one after the other."""
    house.told()
    for one in payloads:
        await house.say(TOPIC, one, retain=retain)
    found = [one.value for report in iter(house.reports.take, None) for one in report.unreadable]
    return [one.removeprefix(f"payloads of W on {TOPIC}: ") for one in found]


def sensor(**fields: object) -> tuple[str, dict[str, object]]:
    return "sensor", fields


def binary(**fields: object) -> tuple[str, dict[str, object]]:
    return "binary_sensor", fields


@pytest.mark.parametrize(
    ("announced", "payload", "why"),
    [
        (binary(device_class="door"), "on", "'on': expects ON or OFF"),
        (binary(device_class="door", payload_on="open", payload_off="shut"), "close", "'close': expects open or shut"),
        (binary(payload_on=True, payload_off=False), "true", "'true': expects True or False"),
        (binary(), '{"state": "ON"}', '\'{"state": "ON"}\': expects ON or OFF'),
        (binary(value_template="{{ value_json.state }}"), "on", "'on': expects ON or OFF"),
        (sensor(device_class="enum", options=["a", "b"]), "c", "'c': expects a or b"),
        (sensor(unit_of_measurement="°C"), "21,5", "'21,5': expects a number"),
        (
            sensor(unit_of_measurement="W", value_template="{{ value | float * 2 }}"),
            "many",
            "its template fails: float",
        ),
        (sensor(value_template="{{ states('sensor.x') }}"), "1", "its template uses `states()`, which only Home"),
        (sensor(value_template="{{ value_json.t }}"), "no JSON", "'no JSON': expects the JSON that its template reads"),
        (sensor(device_class="timestamp"), "2026-11-20T09:00:00", "'2026-11-20T09:00:00': expects a timestamp with"),
        (sensor(), b"\xff", "'�': expects text in utf-8"),
        (("select", {}), "c", "'c': expects a or b"),
        (("number", {}), "11", "'11': expects a possible number"),
        (("climate", {}), "warm", "'warm': expects off or heat"),
        (("cover", {}), "OPEN", "'OPEN': expects closed, open, closing, opening or stopped"),
        (
            ("fan", {"command_topic": "c", "state_topic": "s", "percentage_state_topic": TOPIC}),
            "60.0",
            "'60.0': expects a whole number from 0 to 100",
        ),
        (("event", {}), '{"event_type": "tap"}', "'tap': expects press or hold"),
        (("lock", {}), "locked", "'locked': expects UNLOCKED, LOCKED, UNLOCKING,"),
    ],
)
async def test_what_an_announcement_does_not_explain_is_reported_with_the_reason(
    announced: tuple[str, dict[str, object]], payload: str | bytes, why: str
) -> None:
    async with simple_house(conventions=HA) as house:
        await announce(house, announced[0], **announced[1])
        first, second = await unreadable(house, payload, payload)
        assert first.startswith(f"1, the last {why}")
        assert second.startswith("2, the last")
        assert house.gateway.counters.payloads_unreadable == 2


@pytest.mark.parametrize(
    ("announced", "payloads"),
    [
        (binary(), ("ON", "OFF", "", "None", "unknown", "unavailable", " ")),
        (binary(value_template="{{ value_json.state }}"), ('{"other": 1}', '{"state": null}', "{}", '{"state": ""}')),
        (binary(value_template="{{ value_json.a.b }}"), ('{"other": 1}',)),
        (binary(off_delay=5), ("ON", "another device")),
        (binary(payload_on="A1A66E", payload_off="B1A66E"), ("C1A66E",)),
        (binary(availability_topic=TOPIC), ("online", "offline", "ON")),
        (sensor(unit_of_measurement="°C"), ("21.5", "", "nan", "inf", "null", "N/A", "-")),
        (sensor(unit_of_measurement="W", value_template="{{ value_json.p | float * 2 }}"), ('{"p": null}', '{"q": 1}')),
        (sensor(value_template="{{ value_json.p | is_defined }}"), ('{"q": 1}',)),
        (sensor(device_class="enum", options=["a", "b"]), ("a", "None", "unknown", "")),
        (("select", {}), ("a", "none", "None", "")),
        (("cover", {}), ("open", "None", "")),
        (
            ("light", {"schema": "json", "command_topic": "c", "brightness": True}),
            ('{"state": null, "brightness": 0}',),
        ),
        (("event", {}), ('{"event_type": "press"}', "")),
        (("device_automation", {"type": "a", "subtype": "b", "automation_type": "trigger", "topic": TOPIC}), ("x",)),
    ],
)
async def test_a_doctor_does_not_cry_wolf(announced: tuple[str, dict[str, object]], payloads: tuple[str, ...]) -> None:
    """No value, other keys of a shared topic, other remotes of a receiver, and the words of an availability."""
    async with simple_house(conventions=HA) as house:
        await announce(house, announced[0], **announced[1])
        assert await unreadable(house, *payloads) == []


async def test_a_retained_payload_counts_once_however_often_it_is_read() -> None:
    async with simple_house(conventions=HA) as house:
        await house.say(TOPIC, "on", retain=True)
        for name in ("A", "B", "C"):
            await announce(house, "binary_sensor", name=name)
        assert house.gateway.counters.payloads_unreadable == 1


async def test_one_line_of_the_log_an_hour_for_each_part() -> None:
    with capture_logs() as lines:
        async with simple_house(conventions=HA) as house:
            await announce(house, "binary_sensor")
            await unreadable(house, *["on"] * 5)
            await anyio.sleep(3601)
            await unreadable(house, "on")
    found = [one["message"] for one in lines if one["event"] == "gateway.payload_unreadable"]
    assert [one.partition(" on t: ")[2] for one in found] == [
        "1, the last 'on': expects ON or OFF",
        "6, the last 'on': expects ON or OFF",
    ]


@pytest.mark.parametrize(
    ("component", "payload"),
    [
        ("lock", "7355"),
        ("alarm_control_panel", "7355"),
        ("binary_sensor", '{"pin_code": "7355"}'),
        ("select", '{"user": 1, "user_code": "7355"}'),
    ],
)
async def test_no_code_is_shown(component: str, payload: str) -> None:
    with capture_logs() as lines:
        async with simple_house(conventions=HA) as house:
            await announce(house, component)
            (found,) = await unreadable(house, payload)
    assert "7355" not in f"{found}{lines}"


async def test_a_long_payload_is_cut() -> None:
    async with simple_house(conventions=HA) as house:
        await announce(house, "select")
        (found,) = await unreadable(house, "x" * 10_000)
        assert len(found) < 200


@WHOLE_HOUSE
@pytest.mark.parametrize(
    ("conventions", "announcements", "topic", "payload", "why"),
    [
        (
            "zigbee2mqtt",
            {
                "zigbee2mqtt/bridge/devices": [
                    {
                        "ieee_address": "0x00124b000000000c",
                        "type": "Router",
                        "friendly_name": "plug",
                        "definition": {
                            "model": "M",
                            "vendor": "A",
                            "description": "d",
                            "exposes": [
                                {
                                    "type": "switch",
                                    "features": [
                                        {
                                            "type": "binary",
                                            "name": "state",
                                            "property": "state",
                                            "access": 7,
                                            "value_on": "ON",
                                            "value_off": "OFF",
                                        }
                                    ],
                                }
                            ],
                        },
                    }
                ]
            },
            "zigbee2mqtt/plug",
            '{"state": "on"}',
            "'on': expects ON or OFF",
        ),
        (
            "homie",
            {
                "homie/5/lamp/$state": "ready",
                "homie/5/lamp/$description": {
                    "homie": "5.0",
                    "version": 1,
                    "nodes": {
                        "light": {"properties": {"state": {"datatype": "boolean", "settable": True}}},
                    },
                },
            },
            "homie/5/lamp/light/state",
            "ON",
            "'ON': expects false or true",
        ),
    ],
)
async def test_other_conventions_say_so_too(
    conventions: str, announcements: Mapping[str, object], topic: str, payload: str, why: str
) -> None:
    async with simple_house(conventions=(conventions,)) as house:
        for place, words in announcements.items():
            await house.say(place, words if isinstance(words, str) else json.dumps(words), retain=True)
        house.told()
        await house.say(topic, payload)
        found = [one.value for report in iter(house.reports.take, None) for one in report.unreadable]
        assert [one.partition("the last ")[2] for one in found] == [why]


async def test_of_a_flood_the_first_are_reported_and_then_the_last_once_a_second() -> None:
    """A number that a lamp does not explain cost more than all else that is done for a message."""
    async with simple_house(conventions=HA) as house:
        await announce(house, "binary_sensor")
        counts = [one.partition(",")[0] for one in await unreadable(house, *(f"{number}" for number in range(300)))]
        assert counts == [f"{number}" for number in range(1, 11)]
        await anyio.sleep(3)
        (late,) = [one.value for report in iter(house.reports.take, None) for one in report.unreadable]
        assert late.startswith(f"payloads of W on {TOPIC}: 300, the last '299'")
        assert house.gateway.counters.payloads_unreadable == 300
        (one,) = await unreadable(house, "x")
        assert one.startswith("301, the last 'x'")
