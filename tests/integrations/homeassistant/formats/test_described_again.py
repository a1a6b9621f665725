"""Entities at a gateway: what a description that comes again makes of what was said before."""

import json

import pytest
from tests.gateways.mqtt.simple_house import simple_house

pytestmark = pytest.mark.virtual_time

CONVENTION = "homebot.integrations.homeassistant.formats:HomeAssistantDiscovery"
LAMP = {
    "unique_id": "u",
    "command_topic": "b/set",
    "rgb_command_topic": "b/rgb/set",
    "rgb_state_topic": "b/rgb",
}


@pytest.mark.parametrize("again", [{}, {"name": "Hall"}])
async def test_a_lamp_that_is_announced_again_still_has_its_color(again: dict[str, str]) -> None:
    """Also if its description is the same: it is dimmed by its last colour."""
    async with simple_house(conventions=(CONVENTION,)) as house:
        await house.listen("b/rgb/set")
        await house.say("homeassistant/light/x/config", json.dumps(LAMP), retain=True)
        await house.say("b/rgb", "255,0,0")
        await house.say("homeassistant/light/x/config", json.dumps({**LAMP, **again}), retain=True)
        answer = await house.command("homeassistant:light/x", "u", "level", 40.0)
        assert answer.success
        assert [(one.topic, one.payload) for one in await house.heard()] == [("b/rgb/set", b"102,0,0")]


async def test_a_message_of_one_byte_is_read_as_often_as_it_comes() -> None:
    """Python has one object for all bytes that are equal, and a heavy template its share of each message."""
    heavy = "{% for i in range(3000) %}{% endfor %}{{ value }}"
    config = {"unique_id": "v", "state_topic": "v/state", "value_template": heavy}
    async with simple_house(conventions=(CONVENTION,)) as house:
        await house.say("homeassistant/sensor/v/config", json.dumps(config))
        for _ in range(30):
            await house.say("v/state", "1")
        assert [told for _, told, _ in house.told()] == [{"v.value": "1"}] * 30


BRIDGE = (
    "homebot.integrations.homeassistant.formats:HomeAssistantDiscovery",
    "homebot.integrations.zigbee2mqtt.formats:Zigbee2Mqtt",
)
INFO = "zigbee2mqtt/bridge/info"


@pytest.mark.parametrize("devices", [1, 2_000])
async def test_the_info_of_a_large_bridge_tells_its_entities_their_state(devices: int) -> None:
    """It is as long as an announcement."""
    config = {"unique_id": "v", "state_topic": INFO, "value_template": "{{ value_json.version }}"}
    known = {f"0x{number:016x}": {"friendly_name": "x" * 150, "retain": False} for number in range(devices)}
    info = json.dumps({"version": "2.14.1", "config": {"devices": known}})
    assert (len(info) > 256 * 1024) == (devices > 1)
    async with simple_house(conventions=BRIDGE) as house:
        await house.say("homeassistant/sensor/v/config", json.dumps(config))
        await house.say(INFO, info)
        assert [told for _, told, _ in house.told()] == [{"v.value": "2.14.1"}]
        assert house.gateway.counters.oversize == 0


async def test_a_message_without_a_value_says_that_there_is_none() -> None:
    """EMS-ESP's template invents 0 for a missing value, and its availability says so: ``add_ha_sections_to_doc``."""
    known = "value_json['outdoortemp'] is defined"
    config = {
        "uniq_id": "t",
        "stat_t": "ems-esp/boiler_data",
        "dev_cla": "temperature",
        "unit_of_meas": "°C",
        "val_tpl": f"{{{{value_json['outdoortemp'] if {known} else 0}}}}",
        "avty": [{"t": "ems-esp/boiler_data", "val_tpl": f"{{{{'online' if {known} else 'offline'}}}}"}],
        "avty_mode": "all",
    }
    async with simple_house(conventions=(CONVENTION,)) as house:
        await house.say("homeassistant/sensor/t/config", json.dumps(config))
        await house.say("ems-esp/boiler_data", '{"outdoortemp": 5.5}')
        await house.say("ems-esp/boiler_data", '{"curflowtemp": 40}')
        await house.say("ems-esp/boiler_data", '{"outdoortemp": 6}')
        assert [told for _, told, _ in house.told() if ".reachable" not in told] == [
            {"t.temperature": 5.5},
            {"t.temperature": 6.0},
        ]


async def test_a_sensor_of_the_connection_says_that_it_is_lost() -> None:
    """``ha.txt`` of the Bestway Lay-Z-Spa has one topic for it and for the availability."""
    words = {"avty_t": "spa/Status", "pl_avail": "Alive", "pl_not_avail": "Dead", "pl_on": "Alive", "pl_off": "Dead"}
    config = {"uniq_id": "c", "stat_t": "spa/Status", "dev_cla": "connectivity", **words}
    async with simple_house(conventions=(CONVENTION,)) as house:
        await house.say("homeassistant/binary_sensor/c/config", json.dumps(config))
        await house.say("spa/Status", "Alive")
        await house.say("spa/Status", "Dead")
        assert [told for _, told, _ in house.told() if ".reachable" not in told] == [
            {"c.connectivity": True},
            {"c.connectivity": False},
        ]


async def test_an_announcement_that_says_a_key_twice_is_counted_and_counts_as_it_says_last() -> None:
    async with simple_house(conventions=("homeassistant",)) as house:
        config = '{"unique_id": "a", "command_topic": "x/lamp", "command_topic": "lamp/set", "name": "Lamp"}'
        await house.say("homeassistant/switch/lamp/config", config)
        (sighting,) = house.sighted()
        assert sighting.parts[0].writes == ("lamp/set",)
        assert house.gateway.counters.announcements_ambiguous == 1
        await house.say("homeassistant/switch/other/config", '{"unique_id": "b", "command_topic": "other/set"}')
        assert house.gateway.counters.announcements_ambiguous == 1
