"""Automations with the houses for which they were published do what their authors expect; in virtual time.

A writer who had not seen the reader wrote both, and the plays.
"""

import json
import tomllib
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import anyio
import pytest

from homebot.cli.yaml_loader import load_located
from homebot.clock import read_zone
from homebot.devices import Devices
from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest
from homebot.devices.gateway_messages import Command
from homebot.devices.names import COMMAND_DEVICES
from homebot.devices.part import Part
from homebot.errors import UsageError
from homebot.features.routines.text import read_routines
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.memory import MemoryGateway, MemoryGatewaySettings
from homebot.graph import Node
from homebot.integrations.homeassistant.automations import HomeAssistantAutomations
from homebot.integrations.homeassistant.formats.states.presses import APP_KEY, APP_PARTS, RAW_PART, open_button
from homebot.integrations.homeassistant.gateway.entities import HomeAssistantEntities
from homebot.support.located import Located
from homebot.testing import VirtualHouse, virtual_house_of
from homebot.words.automations import ImportedRoutines

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time]

read_zone("UTC")  # read from the disk before any loop runs
PUBLISHED = Path(__file__).parent / "published"
FILES = {str(path.relative_to(PUBLISHED)): path.read_text("utf-8") for path in PUBLISHED.rglob("*.*")}
HOME = {"zone": "UTC", "latitude": 52.52, "longitude": 13.4}
PLACED = {"input_boolean": False, "schedule": False, "counter": {"counter": 0}, "timer": {"timer": "10m"}}
HELPERS: dict[str, Any] = {
    **PLACED, "input_button": {"button": True}, "input_datetime": {"time": "07:00"}, "input_number": 0.0,
    "input_text": {"text": "none"},
}  # fmt: skip
FIRST = {
    "light": "off", "switch": "off", "binary_sensor": "off", "cover": "closed", "lock": "locked", "sensor": "20",
    "climate": "heat", "vacuum": "docked", "fan": "off", "alarm_control_panel": "disarmed", "person": "home",
    "number": "6", "scene": "unknown", "media_player": "off",
}  # fmt: skip
FEATURES = {"climate": 401, "light": 44, "fan": 49}
"""What entities of these domains can do, if the house does not say it."""


HOUSEHOLDS = {"everyone_left_and_first_home", "heating_schedule", "persons_and_places", "vacuum_when_nobody_home"}
"""The houses whose automations ask for the household: here of Anna, by her phone."""


class Play(NamedTuple):
    """What happens in the house of a file, and what its automations do then.

    Attributes:
        first: States at the beginning, as in *events*, by commas.
        events: Each a time, an entity, its state, and perhaps attributes; or a helper, and a command.
        expected: Each the time, the entity, and the capability with its value, or a message.
        time: The begin and the end.
    """

    name: str
    first: str
    events: Sequence[str]
    expected: Sequence[str] = ()
    time: str = "10:00 11:00"
    day: str = "2026-01-14"


LIGHTS_OF_ALL = ("light.living_room", "light.kitchen", "light.porch")
SET = "temp_comfort number 21, temp_eco number 17, "
PLAYS: tuple[Play, ...] = (
    Play(
        "hallway_motion_lux_timeout",
        "hallway_lux_threshold number 15, sensor.hallway_motion_illuminance 8",
        [
            "20:00 binary_sensor.hallway_motion on",
            "20:00:20 sensor.hallway_motion_illuminance 45",
            "20:01 binary_sensor.hallway_motion off",
            "20:02 binary_sensor.hallway_motion on",
            "20:02:30 binary_sensor.hallway_motion off",
        ],
        ["20:00:00 light.hallway_ceiling level 70", "20:04:30 light.hallway_ceiling on_off False"],
        "19:50 21:00",
    ),
    Play(
        "hallway_motion_lux_timeout",
        "hallway_lux_threshold number 15, sensor.hallway_motion_illuminance 8",
        [
            "20:00 binary_sensor.hallway_motion on",
            "20:01 binary_sensor.hallway_motion off",
            "20:02 binary_sensor.hallway_motion on",
            "20:02:30 binary_sensor.hallway_motion off",
        ],
        [
            "20:00:00 light.hallway_ceiling level 70",
            "20:02:00 light.hallway_ceiling level 70",
            "20:04:30 light.hallway_ceiling on_off False",
        ],
        "19:50 21:00",
    ),
    Play(
        "hallway_motion_lux_timeout",
        "hallway_lux_threshold number 15, sensor.hallway_motion_illuminance 3",
        ["20:00 binary_sensor.hallway_motion on"],
        ["20:00:00 light.hallway_ceiling level 70", "20:30:00 light.hallway_ceiling on_off False"],
        "19:50 21:00",
    ),
    Play(
        "hallway_motion_lux_timeout",
        "hallway_lux_threshold number 15, sensor.hallway_motion_illuminance 15",
        [
            "20:00 binary_sensor.hallway_motion on",
            "20:01 binary_sensor.hallway_motion unavailable",
            "20:01 sensor.hallway_motion_illuminance 4",
            "20:01:30 binary_sensor.hallway_motion on",
        ],
        [],
        "19:50 21:00",
    ),
    Play(
        "bathroom_motion_day_night",
        "sensor.bathroom_humidity 55",
        ["23:10 binary_sensor.bathroom_presence on", "23:12 binary_sensor.bathroom_presence off"],
        [
            "23:10:00 light.bathroom_mirror color_temperature 2200",
            "23:10:00 light.bathroom_mirror level 8",
            "23:17:00 light.bathroom_ceiling on_off False",
            "23:17:00 light.bathroom_mirror on_off False",
        ],
        "23:00 23:30",
    ),
    Play(
        "bathroom_motion_day_night",
        "sensor.bathroom_humidity 55",
        [
            "06:30 binary_sensor.bathroom_presence on",
            "06:33 binary_sensor.bathroom_presence off",
            "06:37 binary_sensor.bathroom_presence on",
            "06:40 binary_sensor.bathroom_presence off",
        ],
        [
            *(
                f"{at}:00 light.bathroom_{lamp} {value}"
                for at in ("06:30", "06:37")
                for lamp in ("ceiling", "mirror")
                for value in ("color_temperature 4000", "level 100")
            ),
            "06:45:00 light.bathroom_ceiling on_off False",
            "06:45:00 light.bathroom_mirror on_off False",
        ],
        "06:20 07:00",
    ),
    Play(
        "bathroom_motion_day_night",
        "sensor.bathroom_humidity 80, light.guest_bathroom_mirror on",
        [
            "07:00 binary_sensor.bathroom_presence on",
            "07:10 binary_sensor.bathroom_presence off",
            "07:16 sensor.bathroom_humidity 70",
        ],
        [
            f"07:00:00 light.bathroom_{lamp} {value}"
            for lamp in ("ceiling", "mirror")
            for value in ("color_temperature 4000", "level 100")
        ],
        "06:50 08:00",
    ),
    Play(
        "bathroom_motion_day_night",
        "bathroom_manual on, sensor.bathroom_humidity 55",
        ["12:00 binary_sensor.bathroom_presence on", "12:05 binary_sensor.bathroom_presence off"],
        [],
        "11:50 12:30",
    ),
    Play(
        "ben_arrives_garage",
        "person.ben not_home, binary_sensor.bens_pixel_android_auto on",
        [
            "18:05 person.ben home",
            "18:05:30 cover.garage_door open",
            "18:06 binary_sensor.garage_motion on",
            "18:07 binary_sensor.garage_motion off",
        ],
        [
            "18:05:00 cover.garage_door movement open",
            "18:05:00 light.driveway on_off True",
            "18:05:00 light.garage on_off True",
            "18:10:00 cover.garage_door movement closed",
            "18:10:00 light.driveway on_off False",
            "18:10:00 light.garage on_off False",
        ],
        "18:00 19:00",
    ),
    Play(
        "ben_arrives_garage",
        "person.ben work, binary_sensor.bens_pixel_android_auto on",
        ["12:00 person.ben home", "12:01 binary_sensor.garage_motion on"],
        ["12:00:00 cover.garage_door movement open"],
        "11:50 12:40",
    ),
    Play(
        "ben_arrives_garage",
        "person.ben not_home, person.anna not_home",
        [
            "17:00 person.ben home",
            "17:30 binary_sensor.bens_pixel_android_auto on",
            "18:00 person.ben work",
            "18:10 person.anna home",
        ],
        [],
        "16:50 19:00",
    ),
    Play(
        "blinds_sun_position",
        "shading on, sensor.weather_station_temperature 26, sensor.weather_station_illuminance 52000, "
        "cover.living_south open, cover.office_south open",
        [],
        [
            "09:34:11 cover.living_south position 30",
            "09:34:11 cover.office_south position 30",
            "09:34:41 cover.living_south tilt 50",
        ],
        "08:00 13:00",
        "2026-06-14",
    ),
    Play(
        "bathroom_fan_humidity",
        "sensor.bathroom_humidity 55, sensor.hallway_humidity 45",
        ["07:00 sensor.bathroom_humidity 62", "07:02 sensor.bathroom_humidity 80", "07:20 sensor.bathroom_humidity 49"],
        ["07:00:00 fan.bathroom fan_speed 99.99", "07:25:00 fan.bathroom on_off False"],
        "06:50 07:50",
    ),
    Play(
        "bathroom_fan_humidity",
        "sensor.bathroom_humidity 50, sensor.hallway_humidity 45",
        ["23:00 sensor.bathroom_humidity 60", "23:05 sensor.hallway_humidity 44"],
        ["23:05:00 fan.bathroom fan_speed 33.33"],
        "22:50 23:30",
    ),
    Play(
        "bathroom_fan_humidity",
        "sensor.bathroom_humidity 55, sensor.hallway_humidity 45",
        ["12:00 fan.bathroom on"],
        ["13:00:00 fan.bathroom on_off False"],
        "11:50 13:30",
    ),
    Play(
        "bathroom_fan_humidity",
        "sensor.bathroom_humidity 55, sensor.hallway_humidity 45, sensor.cellar_humidity 60",
        [
            "10:00 sensor.bathroom_humidity 48",
            "11:00 sensor.hallway_humidity unavailable",
            "11:10 sensor.hallway_humidity 45",
            "11:20 sensor.cellar_humidity 95",
        ],
        [],
        "09:50 12:00",
    ),
    Play(
        "kitchen_timer_motion",
        "kitchen_minutes number 4, house_mode option Evening",
        [
            "19:00 binary_sensor.kitchen_motion on",
            "19:05 binary_sensor.kitchen_motion_table on",
            "19:06 binary_sensor.kitchen_motion off",
            "19:07 binary_sensor.kitchen_motion_table off",
            "19:09 binary_sensor.kitchen_motion on",
            "19:10 binary_sensor.kitchen_motion off",
        ],
        ["19:00:00 light.kitchen level 90", "19:14:00 light.kitchen on_off False"],
        "18:50 19:30",
    ),
    Play(
        "kitchen_timer_motion",
        "kitchen_minutes number 4, house_mode option Night",
        ["23:30 binary_sensor.kitchen_motion on", "23:31 binary_sensor.kitchen_motion off", "23:32 light.kitchen off"],
        ["23:30:00 light.kitchen level 30"],
        "23:20 23:50",
    ),
    Play(
        "kitchen_timer_motion",
        "kitchen_minutes number 10",
        ["12:00 light.kitchen on", "12:01 binary_sensor.kitchen_motion on", "12:02 binary_sensor.kitchen_motion off"],
        ["12:12:00 light.kitchen on_off False"],
        "11:50 12:30",
    ),
    Play(
        "kitchen_timer_motion",
        "kitchen_minutes number 4",
        [
            "13:00 binary_sensor.kitchen_motion on",
            "13:01 binary_sensor.kitchen_motion off",
            "13:20 binary_sensor.hall_motion on",
        ],
        [],
        "12:50 13:40",
    ),
    Play(
        "blueprint_motion_lux",
        "sensor.pantry_illuminance 10",
        ["18:00 binary_sensor.pantry_motion on", "18:00:40 binary_sensor.pantry_motion off"],
        ["18:00:00 light.pantry level 100", "18:02:10 light.pantry on_off False"],
        "17:50 18:30",
    ),
    Play(
        "blueprint_motion_lux",
        "",
        [
            "12:00 binary_sensor.stairs_motion on",
            "12:01 binary_sensor.stairs_motion off",
            "12:02:30 binary_sensor.stairs_motion on",
            "12:02:50 binary_sensor.stairs_motion off",
        ],
        [
            "12:00:00 light.stairs_down level 35",
            "12:00:00 light.stairs_up level 35",
            "12:02:30 light.stairs_down level 35",
            "12:02:30 light.stairs_up level 35",
            "12:04:50 light.stairs_down on_off False",
            "12:04:50 light.stairs_up on_off False",
        ],
        "11:50 12:30",
    ),
    Play(
        "blueprint_motion_lux",
        "sensor.pantry_illuminance 20",
        [
            "18:00 binary_sensor.pantry_motion on",
            "18:00:01 sensor.pantry_illuminance 120",
            "18:01 binary_sensor.pantry_motion off",
            "18:01:30 binary_sensor.pantry_motion on",
            "18:02 binary_sensor.pantry_motion off",
        ],
        ["18:00:00 light.pantry level 100", "18:02:30 light.pantry on_off False"],
        "17:50 18:30",
    ),
    Play(
        "blueprint_motion_lux",
        "sensor.pantry_illuminance 25, party on",
        ["10:00 binary_sensor.pantry_motion on", "10:10 binary_sensor.stairs_motion on"],
        [],
        "09:50 10:40",
    ),
    Play(
        "heating_schedule",
        f"{SET}heating_season on, climate.living_room heat temperature=17",
        ["06:30 heating_living_room on", "08:30 heating_living_room off"],
        [
            "06:30:00 climate.living_room heating_setpoint 21",
            "06:30:00 climate.living_room thermostat_mode heat",
            "08:30:00 climate.living_room heating_setpoint 17",
            "08:30:00 climate.living_room thermostat_mode heat",
        ],
        "06:20 09:00",
    ),
    Play(
        "heating_schedule",
        f"{SET}heating_season on, heating_living_room on, climate.living_room heat temperature=21",
        ["18:00 temp_comfort number 22.5", "18:05 temp_eco number 16"],
        ["18:00:00 climate.living_room heating_setpoint 22.5", "18:00:00 climate.living_room thermostat_mode heat"],
        "17:50 18:30",
    ),
    Play(
        "heating_schedule",
        f"{SET}heating_living_room on, anna not_home, climate.living_room heat temperature=21",
        ["10:00 heating_season on"],
        ["10:00:00 climate.living_room heating_setpoint 17", "10:00:00 climate.living_room thermostat_mode heat"],
        "09:50 10:30",
    ),
    Play(
        "heating_schedule",
        f"{SET}heating_season on, climate.living_room heat temperature=17, binary_sensor.living_window on",
        [
            "06:30 heating_living_room on",
            "08:00 binary_sensor.living_window off",
            "09:00 heating_living_room off",
            "11:00 heating_bathroom on",
        ],
        [],
        "06:20 11:30",
    ),
    Play(
        "device_triggers_terrace",
        "switch.infrared_heater on, sensor.living_temperature 18.5",
        ["10:00 binary_sensor.terrace_door_contact on", "10:08 binary_sensor.terrace_door_contact off"],
        ["10:01:00 switch.infrared_heater on_off False", "10:08:00 switch.infrared_heater on_off True"],
        "09:50 10:30",
    ),
    Play(
        "device_triggers_terrace",
        "switch.infrared_heater on, sensor.living_temperature 20",
        ["10:00 binary_sensor.terrace_door_contact on", "10:08 binary_sensor.terrace_door_contact off"],
        ["10:01:00 switch.infrared_heater on_off False"],
        "09:50 10:30",
    ),
    Play(
        "device_triggers_terrace",
        "switch.infrared_heater on, sensor.living_temperature 15",
        [
            "10:00 binary_sensor.terrace_door_contact on",
            "10:30 binary_sensor.terrace_door_contact off",
            "11:00 light.terrace on",
        ],
        ["10:01:00 switch.infrared_heater on_off False", "11:00:00 light.terrace level 80"],
        "09:50 11:30",
    ),
    Play(
        "device_triggers_terrace",
        "light.terrace on",
        [
            "12:00 binary_sensor.terrace_door_contact on",
            "12:05 binary_sensor.terrace_door_contact off",
            "13:00 switch.infrared_heater on",
            "13:10 binary_sensor.terrace_door_contact on",
            "13:10:50 binary_sensor.terrace_door_contact off",
            "14:00 binary_sensor.front_door_contact on",
            "14:30 light.terrace off",
        ],
        [],
        "11:50 15:00",
    ),
    Play(
        "everyone_left_and_first_home",
        "alarm_control_panel.house armed_away, anna not_home",
        ["17:30 anna home"],
        [
            "17:30:01 alarm_control_panel.house alarm disarmed",
            "17:30:01 climate.bedroom preset_mode home",
            "17:30:01 climate.living_room preset_mode home",
        ],
        "17:20 18:00",
    ),
    Play(
        "everyone_left_and_first_home",
        "",
        ["08:10 anna not_home"],
        [
            "08:15:01 alarm_control_panel.house alarm armed_away",
            "08:15:01 climate.bedroom preset_mode away",
            "08:15:01 climate.living_room preset_mode away",
            *(f"08:15:01 {lamp} on_off False" for lamp in LIGHTS_OF_ALL),
            "08:15:01 lock.front_door lock locked",
        ],
        "08:00 09:00",
    ),
    Play(
        "everyone_left_and_first_home",
        "binary_sensor.bedroom_window on",
        ["08:00 anna not_home"],
        [
            "08:05:01 climate.bedroom preset_mode away",
            "08:05:01 climate.living_room preset_mode away",
            *(f"08:05:01 {lamp} on_off False" for lamp in LIGHTS_OF_ALL),
            "08:05:01 lock.front_door lock locked",
            "08:05:01 notify Alarm not armed: Still open: Bedroom Window",
        ],
        "07:50 09:00",
    ),
    Play("everyone_left_and_first_home", "guest_mode on", ["09:30 anna not_home"], [], "09:20 10:00"),
    Play(
        "vacuum_when_nobody_home",
        "vacuum.rosie cleaning, anna not_home",
        ["12:00 anna home"],
        ["12:00:01 vacuum.rosie vacuum returning"],
        "11:50 12:30",
    ),
    Play(
        "vacuum_when_nobody_home",
        "vacuum_runs number 2",
        ["09:30 anna not_home", "09:50 vacuum.rosie docked", "10:30 anna home", "12:00 anna not_home"],
        ["09:45:01 vacuum.rosie vacuum cleaning"],
        "09:00 13:00",
    ),
    Play(
        "vacuum_when_nobody_home",
        "vacuum_runs number 4",
        ["11:00 vacuum_now push"],
        [
            "11:00:00 notify Rosie has cleaned 5 times, please empty the bin.",
            "11:00:00 vacuum.rosie vacuum cleaning",
        ],
        "10:50 11:30",
        "2026-01-18",
    ),
    Play(
        "vacuum_when_nobody_home",
        "anna not_home",
        ["10:30 anna home", "16:00 anna not_home", "16:10 anna home"],
        [],
        "10:00 17:00",
    ),
    Play(
        "ev_solar_charging",
        "binary_sensor.wallbox_car_connected on, charge_mode option Solar",
        ["13:02 charge_mode option Fast"],
        ["13:02:00 number.wallbox_current number 16", "13:02:00 switch.wallbox_charging on_off True"],
        "12:50 13:30",
    ),
    Play("ev_solar_charging", "charge_mode option Solar", ["13:02 charge_mode option Fast"], [], "12:50 13:30"),
    Play(
        "blinds_sun_position",
        "shading on, sensor.weather_station_temperature 19, sensor.weather_station_illuminance 60000, "
        "cover.living_south open, cover.office_south open",
        ["11:00 sensor.weather_station_temperature 24"],
        [],
        "08:00 17:00",
        "2026-06-14",
    ),
    Play(
        "group_of_windows",
        "light.hall on, switch.fan_plug on",
        [
            "10:05 binary_sensor.kitchen_window on",
            "10:10 binary_sensor.bedroom_window on",
            "10:15 binary_sensor.kitchen_window off",
            "10:20 binary_sensor.bedroom_window off",
        ],
        ["10:05:00 notify A window is open", "10:20:00 switch.fan_plug on_off False"],
    ),
    Play(
        "ios_action_goodnight",
        "light.living_ceiling on",
        ["22:45 home_assistant_app#action GOODNIGHT"],
        [
            "22:45:00 climate.living_room heating_setpoint 17.5",
            "22:45:00 cover.all_blinds movement closed",
            "22:45:00 light.bedside level 20",
            "22:45:00 light.kitchen_counter on_off False",
            "22:45:00 light.living_ceiling on_off False",
            "22:55:00 light.bedside on_off False",
            "22:55:00 lock.front_door lock locked",
        ],
        "22:40 23:10",
    ),
    Play(
        "ios_action_goodnight",
        "",
        [
            "22:45 home_assistant_app#action GOODNIGHT",
            "22:48 home_assistant_app#action GOODMORNING",
        ],
        [
            "22:45:00 climate.living_room heating_setpoint 17.5",
            "22:45:00 cover.all_blinds movement closed",
            "22:45:00 light.bedside level 20",
            "22:45:00 light.kitchen_counter on_off False",
            "22:45:00 light.living_ceiling on_off False",
            "22:48:00 climate.living_room heating_setpoint 21",
            "22:48:00 cover.all_blinds movement open",
        ],
        "22:40 23:10",
    ),
    Play(
        "ios_action_goodnight",
        "",
        ["12:00 home_assistant_app#action LUNCH", "12:01 home_assistant_app#tag GOODNIGHT"],
        [],
        "11:50 12:30",
    ),
    Play(
        "remotes",
        "living_scene option Read",
        [
            "20:00 living_dial#event_living_dial_button_1 short_release",
            "20:01 living_dial#event_living_dial_button_2 short_release",
            "20:02 living_dial#event_living_dial_button_3 short_release",
            "20:03 tradfri#event on",
            "20:04 tradfri#event off",
            "20:05 dimmer#event 1002",
            "20:06 dimmer#event 4002",
        ],
        [
            "20:00:00 scene.living_relax scene True",
            "20:01:00 light.floor_lamp on_off True",
            "20:02:00 light.sofa_lamp on_off False",
            "20:03:00 light.hall on_off True",
            "20:04:00 light.hall on_off False",
            "20:05:00 light.kitchen on_off True",
            "20:06:00 light.kitchen on_off False",
        ],
        "19:50 20:10",
    ),
    Play(
        "remotes",
        "",
        [
            "20:00 living_dial#event_living_dial_button_1 initial_press",
            "20:01 living_dial#event_living_dial_button_3 long_release",
            "20:03 tradfri#event stop",
            "20:05 dimmer#event 1001",
        ],
        [],
        "19:50 20:10",
    ),
    Play(
        "window_open_heating",
        "climate.office heat temperature=21",
        [
            "09:00 binary_sensor.office_window_left on",
            "09:05 binary_sensor.office_window_right on",
            "09:20 binary_sensor.office_window_left off",
            "09:30 binary_sensor.office_window_right off",
        ],
        [
            "09:02:00 climate.office thermostat_mode off",
            "09:30:30 climate.office thermostat_mode heat",
        ],
        "08:50 10:00",
    ),
    Play(
        "window_open_heating",
        "climate.office heat temperature=21, sensor.office_temperature 14.26",
        ["09:00 binary_sensor.office_window_right on", "11:00 binary_sensor.office_window_right off"],
        [
            "09:02:00 climate.office thermostat_mode off",
            "10:02:00 notify Office window open for an hour, it is 14.3 °C inside.",
            "11:00:30 climate.office thermostat_mode heat",
        ],
        "08:50 11:30",
    ),
    Play(
        "window_open_heating",
        "climate.office heat temperature=21",
        ["09:00 binary_sensor.office_window_left on", "09:01:50 binary_sensor.office_window_left off"],
        [],
        "08:50 10:00",
    ),
    Play(
        "window_open_heating",
        "media_player.kitchen playing volume_level=0.3",
        [],
        ["12:00:00 media_player.kitchen volume 60", "12:10:00 media_player.kitchen volume 30"],
        "11:50 12:30",
    ),
    Play(
        "steps_of_values",
        "media_player.kitchen playing volume_level=0.3",
        [
            "10:00 louder push",
            "10:05 louder push",
            "10:10 media_player.kitchen playing volume_level=0.98",
            "10:11 louder push",
            "10:15 limited push",
            "10:20 brighter push",
            "10:30 party push",
        ],
        [
            "10:00:00 media_player.kitchen volume 35",
            "10:05:00 media_player.kitchen volume 40",
            "10:11:00 media_player.kitchen volume 100",
            "10:15:00 media_player.kitchen volume 60",
            "10:20:00 light.hall level 20",
            "10:30:00 light.hall effect colorloop",
        ],
        "09:50 10:40",
    ),
    Play(
        "steps_of_values",
        "sensor.hall 21, sensor.study 25",
        [
            "10:00 warm push",
            "10:05 sensor.study 25.5",
            "10:06 warm push",
            "10:10 sensor.hall 17.5",
            "10:11 warm push",
        ],
        ["10:06:00 notify Open a window"],
    ),
    Play("steps_of_values", "", ["10:05 media_player.bath playing volume_level=0.5"]),
    Play(
        "calculated",
        "adaptive_light on, light.living_room on",
        ["05:35 light.living_room off", "05:36 light.living_room on", "06:10 adaptive_light off"],
        [
            f"{at}:00 light.living_room {value}"
            for at, values in (
                ("05:00", ("level 32", "color_temperature 2470")),
                ("05:30", ("level 46", "color_temperature 2785")),
                ("05:36", ("level 48", "color_temperature 2830")),
                ("06:00", ("level 60", "color_temperature 3100")),
            )
            for value in values
        ],
        "04:50 06:20",
        "2026-03-20",
    ),
    Play("calculated", "light.hall on, light.kitchen on", [], ["23:30:00 notify 2 lights are still on"], "23:20 23:40"),
    Play("calculated", "light.hall on", [], [], "23:20 23:40"),
    Play(
        "calculated",
        "sensor.hall_battery 9, sensor.bath_battery 80",
        ["10:05 report push", "10:10 sensor.bath_battery 19.5", "10:15 report push"],
        [
            "10:05:00 notify 1 low battery: Hall motion battery 9 %",
            "10:15:00 notify 2 low batteries: Bath window battery 20 %, Hall motion battery 9 %",
        ],
    ),
    Play(
        "calculated",
        "pause number 2.5, sensor.bedroom_temperature 20.4",
        [
            "10:00 both push",
            "10:10 later push",
            "10:20 radio push",
            "10:21 media_player.kitchen idle",
            "10:25 media_player.kitchen standby",
        ],
        [
            "10:00:00 light.hall on_off True",
            "10:00:02 light.kitchen on_off True",
            "10:00:05 light.hall on_off False",
            "10:00:08 light.kitchen on_off False",
            "10:14:00 light.hall on_off True",
            "10:20:00 media_player.kitchen option AUX",
            "10:25:00 notify The radio is off",
        ],
        "09:50 10:30",
    ),
    Play(
        "calculated",
        "pause number 2.5, sensor.bedroom_temperature 20.6, media_player.kitchen playing",
        ["10:10 later push", "10:20 radio push", "10:25 media_player.kitchen idle"],
    ),
    Play("calculated", "sensor.hall_battery 20, sensor.bath_battery 80", ["10:05 report push"]),
    Play(
        "calculated",
        "fan.bedroom on",
        [
            "10:05 sensor.bedroom_temperature 23.44",
            "10:10 sensor.bedroom_temperature 20.5",
            "10:15 sensor.bedroom_temperature 35",
        ],
        [
            "10:05:00 fan.bedroom fan_speed 34",
            "10:10:00 fan.bedroom fan_speed 10",
            "10:15:00 fan.bedroom fan_speed 100",
        ],
    ),
    Play("calculated", "", ["10:05 sensor.bedroom_temperature 23.44"]),
    Play(
        "calculated",
        "media_player.kitchen playing volume_level=0.3",
        [
            "10:05 quieter push",
            "10:10 quieter push",
            "10:15 quieter push",
            "10:20 fan.bedroom on",
            "10:25 quieter push",
        ],
        [
            "10:05:00 media_player.kitchen volume 20",
            "10:10:00 media_player.kitchen volume 10",
            "10:15:00 media_player.kitchen volume 5",
            "10:25:00 media_player.kitchen volume 5",
        ],
    ),
    Play("calculated", "", [], [f"06:3{at}:00 light.hall level {25 * at + 25}" for at in range(4)], "06:20 06:40"),
    Play(
        "calculated",
        "sensor.bedroom_temperature 20, sensor.outside_temperature 9.5",
        [],
        ["12:00:00 notify 10.5 degrees warmer inside"],
        "11:50 12:10",
    ),
    Play(
        "calculated",
        "sensor.bedroom_temperature 20, sensor.outside_temperature 10",
        [],
        ["12:00:00 notify 10 degrees warmer inside"],
        "11:50 12:10",
    ),
    Play("calculated", "sensor.bedroom_temperature 20, sensor.outside_temperature 10.1", [], [], "11:50 12:10"),
    Play(
        "ev_solar_charging",
        "binary_sensor.wallbox_car_connected on, charge_mode option Solar, sensor.grid_power -2100, "
        "sensor.wallbox_power 0",
        [
            "12:01 switch.wallbox_charging on",
            "12:01:01 sensor.wallbox_power 2070",
            "12:01:02 sensor.grid_power -30",
            "12:06 sensor.grid_power -1900",
            "12:11 sensor.grid_power 1500",
        ],
        [
            "12:00:00 number.wallbox_current number 9",
            "12:00:00 switch.wallbox_charging on_off True",
            "12:05:00 number.wallbox_current number 9",
            "12:10:00 number.wallbox_current number 16",
            "12:15:00 switch.wallbox_charging on_off False",
        ],
        "11:58 12:20",
    ),
    Play(
        "ev_solar_charging",
        "binary_sensor.wallbox_car_connected on, charge_mode option Solar, sensor.grid_power -1300, "
        "sensor.wallbox_power 0",
        [],
        [],
        "14:51 15:00",
    ),
    Play("group_of_windows", "binary_sensor.bedroom_window on", ["10:05 binary_sensor.kitchen_window on"]),
    Play("presence_simulation_random", "vacation on", [], ["18:03:20 light.living_room on_off True"], "17:45 18:25"),
    Play(
        "thirsty_plants",
        "sensor.monstera_moisture 21",
        ["14:00 sensor.monstera_moisture 19"],
        [
            "15:00:00 light.plant_shelf color (0.0, 100.0)",
            "15:00:00 light.plant_shelf level 40",
            "15:00:00 notify 🌱 Monstera is thirsty: Moisture is down to 19 %.",
            "15:05:00 light.plant_shelf on_off False",
        ],
        "13:50 15:30",
    ),
    Play(
        "thirsty_plants",
        "sensor.monstera_moisture 22, sensor.basil_moisture 25",
        [
            "12:00 sensor.monstera_moisture 15",
            "12:50 sensor.monstera_moisture 60",
            "21:30 sensor.basil_moisture 15",
        ],
        [],
        "11:50 22:40",
    ),
    Play("presence_simulation_random", "", [], [], "17:45 18:25"),
    Play(
        "lists_of_entities",
        "sensor.door_battery 15.4, sensor.valve_battery unavailable, sensor.phone_battery 5",
        ["17:58 binary_sensor.kitchen_window on"],
        [
            "18:00:00 notify Door battery 15 %",
            "22:00:00 light.hall on_off False",
            "22:00:00 notify 1 open: Kitchen window",
        ],
        "17:50 22:10",
    ),
    Play("lists_of_entities", "sensor.phone_battery 5", [], ["22:00:00 light.hall on_off False"], "17:50 22:10"),
    Play(
        "lists_of_entities",
        "light.sofa on, light.hall on",
        ["23:00 sensor.bedroom_temperature unavailable", "23:10 sensor.kitchen_temperature 17"],
        ["23:30:00 notify Still on: Hall light, Sofa light"],
        "22:50 23:50",
    ),
    Play("lists_of_entities", "light.hall on", ["23:10 sensor.kitchen_temperature 17"], [], "22:50 23:50"),
    Play("lists_of_entities", "light.sofa on", ["23:10 sensor.kitchen_temperature 18"], [], "22:50 23:50"),
    Play(
        "ends_and_events",
        "switch.stove on",
        [
            "10:10 binary_sensor.kitchen_smoke on",
            "10:10:20 binary_sensor.kitchen_smoke off",
            "10:10:40 binary_sensor.kitchen_smoke on",
        ],
        [
            "10:10:00 siren.hall on_off True",
            "10:10:00 light.hall on_off True",
            *(f"10:10:{at} notify Smoke at 10:10" for at in ("00", "40")),
            "10:10:00 switch.stove on_off False",
            "10:11:40 siren.hall on_off False",
        ],
    ),
    Play(
        "ends_and_events",
        "quiet on",
        ["10:10 binary_sensor.kitchen_smoke on"],
        [
            "10:10:00 light.hall on_off True",
            "10:10:00 siren.hall on_off True",
            "10:11:00 siren.hall on_off False",
        ],
    ),
    Play(
        "ends_and_events",
        "sensor.outside 21.5",
        ["10:10 binary_sensor.mailbox on", "10:20 binary_sensor.fridge on"],
        [
            "10:11:00 notify There is mail",
            "10:11:00 notify Mail at 10:11 and 21.5 degrees",
            "10:23:00 notify Open for 3 minutes",
        ],
    ),
    Play(
        "ends_and_events",
        "",
        [
            "10:10 binary_sensor.mailbox on",
            "10:10:50 binary_sensor.mailbox off",
            "10:20 binary_sensor.fridge on",
            "10:22 binary_sensor.fridge off",
        ],
    ),
    Play(
        "ends_and_events",
        "",
        ["10:10 sensor.phone_next_alarm 2026-01-14T10:40:00+00:00"],
        ["10:20:00 light.hall level 52"],
    ),
    Play("ends_and_events", "", ["10:10 sensor.phone_next_alarm 2026-01-15T10:40:00+00:00"]),
    Play(
        "ends_and_events",
        "sensor.outside 20",
        ["10:10 sensor.outside 25.5", "10:20 quiet on", "10:21 sensor.outside 26.5", "10:30 sensor.outside 24"],
        [
            "10:10:00 light.hall level 55",
            "10:10:00 switch.stove on_off True",
            "10:21:00 light.hall level 65",
            "10:21:00 switch.stove on_off False",
        ],
    ),
    Play("ends_and_events", "sensor.outside 20", ["10:10 sensor.outside 25"]),
    Play(
        "numbers_and_lengths",
        "sensor.hall 23, sensor.bedroom 25.5, switch.pump on, update.core off",
        [
            '10:05 update.core on latest_version="2026.2"',
            "10:10 switch.pump off",
            "10:20 binary_sensor.hall_window on",
            "10:21 binary_sensor.kitchen_window on",
        ],
        [
            "10:05:00 notify Version 2026.2",
            "10:10:00 notify Watered 2026-01-14 10:10:00",
            "10:25:00 notify Open for 5 minutes",
            "10:30:00 notify Up to 25.5 degrees, 48.5 together",
            "10:36:00 notify Open for 15 minutes",
        ],
    ),
    Play(
        "numbers_and_lengths",
        "sensor.hall 22, sensor.bedroom unavailable",
        ["10:20 binary_sensor.kitchen_window on", "10:30 binary_sensor.kitchen_window off"],
    ),
    Play(
        "numbers_and_lengths",
        "switch.pump on, evening on",
        ["12:20 evening off"],
        [
            "12:00:00 notify Pump is on, 2026-01-14 12:00:00",
            "12:30:00 notify Pump is on, 2026-01-14 12:30:00",
        ],
        "11:50 12:40",
    ),
    Play("numbers_and_lengths", "", ["12:20 evening on"], [], "11:50 12:40"),
    Play("numbers_and_lengths", "evening on", ["12:20 evening off"], [], "11:50 12:40", "2026-01-15"),
    Play(
        "numbers_and_lengths",
        "sensor.hall 25",
        ["13:02 sensor.hall 20"],
        ["13:00:00 switch.pump on_off True", "13:05:00 notify It was warm"],
        "12:50 13:10",
    ),
    Play(
        "numbers_and_lengths",
        "sensor.hall 20",
        ["13:02 sensor.hall 25"],
        ["13:00:00 switch.pump on_off False"],
        "12:50 13:10",
    ),
    Play(
        "numbers_and_lengths",
        "evening on",
        [
            "10:10 binary_sensor.stairs_motion on",
            "10:15 evening off",
            "10:15:30 binary_sensor.stairs_motion off",
            "10:30 binary_sensor.hall_motion on",
        ],
        [
            "10:10:00 light.hall on_off True",
            "10:20:00 light.hall on_off False",
            "10:30:00 light.hall on_off True",
            "10:31:00 light.hall on_off False",
        ],
    ),
    Play(
        "remotes",
        "",
        [
            "20:00 living_dial#event_living_dial_button_3 long_press",
            "20:01 living_dial#event_living_dial_button_3 initial_press",
            "20:02 living_dial#event_living_dial_button_2 long_press",
        ],
        ["20:00:00 light.hall on_off True"],
        "19:50 20:10",
    ),
    Play(
        "persons_and_places",
        "",
        ["10:10 anna not_home", "10:30 anna home"],
        [
            "10:10:01 light.hall on_off False",
            "10:20:01 lock.front_door lock locked",
            "10:30:01 light.hall on_off True",
        ],
    ),
    Play(
        "persons_and_places",
        "",
        ["10:10 anna not_home", "10:15 anna home", "10:20 binary_sensor.hall_motion on"],
        ["10:10:01 light.hall on_off False", "10:15:01 light.hall on_off True"],
    ),
    Play(
        "persons_and_places",
        "anna not_home, device_tracker.guest_phone unknown",
        ["10:30 binary_sensor.hall_motion on"],
        ["10:30:00 notify Somebody is in the hall"],
    ),
    Play(
        "persons_and_places",
        "device_tracker.guest_phone home",
        [
            "10:10 device_tracker.guest_phone not_home",
            "10:20 device_tracker.guest_phone Office",
            "10:25 device_tracker.guest_phone Office latitude=52.1",
            "10:30 device_tracker.guest_phone unavailable",
            "10:35 device_tracker.guest_phone Office",
        ],
        [
            "10:10:00 notify The guest was in home",
            "10:20:00 notify Office",
            "10:20:00 notify The guest was in not_home",
        ],
    ),
    Play(
        "persons_and_places",
        "device_tracker.guest_phone city_gym, anna not_home",
        ["10:05 device_tracker.guest_phone home", "10:08 binary_sensor.hall_motion on"],
        [
            "10:05:00 notify The guest was in city_gym",
            "10:05:00 notify home",
        ],
    ),
)


OTHERS: tuple[tuple[str, str, tuple[str, ...], tuple[Part, ...]], ...] = (
    (APP_KEY, "Home Assistant app", (), APP_PARTS),
    ("tradfri", "Tradfri", ("00:0b:57:ff:fe:12:34:56",), (open_button(RAW_PART, "event"),)),
    ("dimmer", "Kitchen dimmer", (), (open_button(RAW_PART, "event"),)),
)
"""What has no entities: key, name, identifiers and parts; what it presses is an event ``dimmer#event 1002``."""


class House(NamedTuple):
    """A house from a file.

    Attributes:
        listed: Its entities, as the file lists them.
        helpers: The table ``[helpers]``.
        people: The table ``[people]``.
    """

    listed: Sequence[dict[str, Any]]
    helpers: dict[str, Any]
    people: dict[str, Any]


class HousesGateway(MemoryGateway):
    """The devices of a house, with the states of Home Assistant; it records each command with its time."""

    def __init__(self, node: Node, house: House) -> None:
        super().__init__(node, MemoryGatewaySettings(act=True))
        self.done: list[tuple[float, str]] = []
        self._entities = HomeAssistantEntities(1000)
        self._attributes: dict[str, dict[str, Any]] = {}
        self._keys: dict[str, str] = {}
        self._ids: dict[tuple[str, str], str] = {}
        self._trackers: dict[str, str] = {}
        for entity in house.listed:
            entity_id, attributes = (
                entity["entity_id"],
                {"friendly_name": entity["name"], **entity.get("attributes", {})},
            )
            domain = entity_id.partition(".")[0]
            if domain in FEATURES and "supported_features" not in attributes:
                attributes["supported_features"] = FEATURES[domain]
            self._attributes[entity_id] = attributes
            self._put(entity_id, FIRST.get(domain, "unknown"), {})
        self._entities.regroup()
        for entity in house.listed:
            if key := self._entities.key_of(entity["entity_id"]):
                described, own = self._entities.describe(key), self._attributes[entity["entity_id"]]
                self._keys[entity["entity_id"]] = place = own.get("device_id", key)
                for part in described.parts:
                    self._ids[place, part.id] = entity["entity_id"]
                area, name = entity.get("area", ""), own.get("device_name", described.name)
                siblings = [one for one in house.listed if one.get("attributes", {}).get("device_id") == place]
                keys = [self._entities.key_of(one["entity_id"]) for one in siblings] or [key]
                parts = tuple(part for one in keys for part in self._entities.describe(one).parts)
                device = GatewayDevice(place, name, parts, described.metadata, area=area)
                if place not in self.devices.keys:
                    self.devices.put(device, "it is played")
        for key, called, ids, buttons in OTHERS:
            self.devices.put(GatewayDevice(key, called, buttons, {}, ids), "it is played")
        for name in house.people:
            tracker = HomeAssistantEntities(1)
            tracker.put(f"device_tracker.{name}", {"s": "home", "a": {"friendly_name": f"{name} phone"}}, is_new=True)
            tracker.regroup()
            described = tracker.describe(tracker.key_of(f"device_tracker.{name}"))
            self._trackers[name] = described.parts[0].id
            self.devices.put(GatewayDevice(name, described.name, described.parts), "it is played")

    def _put(self, entity_id: str, state: str, given: dict[str, Any]) -> None:
        self._attributes[entity_id] |= given
        self._entities.put(entity_id, {"s": state, "a": self._attributes[entity_id]}, is_new=True)

    async def begin(self) -> None:
        for entity_id in self._keys:
            await self.tell(f"{entity_id} {FIRST.get(entity_id.partition('.')[0], 'unknown')}")
        for name in self._trackers:
            await self.tell(f"{name} home")

    async def tell(self, line: str) -> None:
        """Report the state of an entity."""
        entity_id, state, *given = line.split(" ")
        if "#" in entity_id:
            key, _, part = entity_id.partition("#")
            await self.devices.report(key, {"press": state}, part)
            return
        if entity_id not in self._keys:
            await self.devices.report(entity_id, {"place": state}, self._trackers[entity_id])
            return
        self._put(entity_id, state, {key: json.loads(value) for key, _, value in (one.partition("=") for one in given)})
        key = self._entities.key_of(entity_id)
        (entity,) = self._entities.of(key)
        place = self._keys[entity_id]
        self.devices.report_reachable(place, reachable=entity.is_available)
        if values := entity.read(is_change=True):
            await self.devices.report(place, values, entity.entry.part_id)

    async def _perform(self, command: Command) -> None:
        await super()._perform(command)
        value = command.value.plain()
        if command.capability == "fan_speed":
            await self.devices.report(command.key, {"on_off": value != 0.0}, command.part)
        text = f"{value:.4g}" if isinstance(value, float) else str(value)
        entity = self._ids.get((command.key, command.part), command.key)
        self.done.append((self.node.graph.clock.now(), f"{entity} {command.capability} {text}"))


@cache
def house_of(name: str) -> House:
    listed = json.loads(FILES[f"{name}.house.json"])
    helpers: dict[str, Any] = {}
    for entity in listed:
        domain, _, own = entity["entity_id"].partition(".")
        options = entity.get("attributes", {}).get("options")
        if domain == "input_select":
            helpers[own] = options
        elif domain in HELPERS:
            helpers[own] = HELPERS[domain]
    people = {"anna": {"trackers": ["anna phone"]}} if name in HOUSEHOLDS else {}
    left_out = {*HELPERS, "input_select", *(["person"] if people else [])}
    shown = [entity for entity in listed if entity["entity_id"].partition(".")[0] not in left_out]
    return House(shown, helpers, people)


def config_of(name: str) -> dict[str, Any]:
    house = house_of(name)
    people = {"people": house.people} if house.people else {}
    return {"home": HOME, "helpers": house.helpers, "notify": {}, **people}


def load(name: str) -> Located:
    if name not in FILES:
        raise UsageError(f"there is no {name}")
    return load_located(FILES[name])


_read: dict[str, ImportedRoutines] = {}


async def imported(name: str) -> ImportedRoutines:
    """Return the routines of the file *name* in its house."""
    if name not in _read:
        async with (
            virtual_house_of(config=config_of(name)) as house,
            Node(house.runtime.graph, "homeassistant", namespace="/gateway") as node,
            anyio.create_task_group() as tasks,
        ):
            gateway = HousesGateway(node, house_of(name))
            await tasks.start(gateway.serve)
            await house.run_for("20s")
            devices = tuple(await Devices(node).find())
            tasks.cancel_scope.cancel()
        _read[name] = HomeAssistantAutomations().read(
            load(f"{name}.yaml"),
            f"{name}.yaml",
            devices,
            lambda text, origin: read_routines(text, origin)[0],
            load=load,
        )
    return _read[name]


async def happens(line: str, house: VirtualHouse, gateway: HousesGateway, helpers: dict[str, Any]) -> None:
    first, _, rest = line.partition(" ")
    if first in helpers:
        commands = gateway.node.create_client(CommandDevices, COMMAND_DEVICES)
        assert (await commands.call(CommandDevicesRequest(target=first.replace("_", " "), command=rest))).success, line
    else:
        await gateway.tell(line)


def stamped(lines: Sequence[tuple[float, str]]) -> Iterator[str]:
    for at, text in lines:
        yield f"{datetime.fromtimestamp(at, UTC):%H:%M:%S} {text}"


@pytest.mark.parametrize("play", PLAYS, ids=lambda play: f"{play.name}, {len(play.expected)}")
async def test_an_automation_does_what_its_author_expects(play: Play) -> None:
    found = await imported(play.name)
    config = config_of(play.name) | tomllib.loads("\n".join(found.texts))
    begin, end = play.time.split()
    async with (
        virtual_house_of(config=config, start=f"{play.day} {begin}") as house,
        Node(house.runtime.graph, "homeassistant", namespace="/gateway") as node,
        anyio.create_task_group() as tasks,
    ):
        gateway = HousesGateway(node, house_of(play.name))
        await tasks.start(gateway.serve)
        await gateway.begin()
        for line in filter(None, play.first.split(", ")):
            await happens(line, house, gateway, house_of(play.name).helpers)
        await house.run_for("30s")
        gateway.done.clear()
        for event in play.events:
            at, _, line = event.partition(" ")
            await house.run_until(at)
            await happens(line, house, gateway, house_of(play.name).helpers)
        await house.run_until(end)
        told = [
            (one.time.timestamp(), f"notify {one.message}")
            for one in house.notifications
            if not one.app.endswith("alerts")
        ]
        tasks.cancel_scope.cancel()
    assert sorted(stamped([*gateway.done, *told])) == sorted(play.expected)


async def test_a_group_with_a_length_of_time_or_of_all_its_members_is_refused() -> None:
    found = await imported("group_of_windows")
    assert [(one.name, one.problem.partition(";")[0]) for one in found.refused] == [
        ("Windows for long", "trigger state: group.all_windows is known to be on or off, without `for`"),
        ("All windows open", "group.all_of_them is nothing that homebot knows"),
    ]


async def test_a_kept_value_is_brought_back_only_with_all_that_was_set() -> None:
    found = await imported("window_open_heating")
    assert list(dict.fromkeys(one.name for one in found.refused)) == [
        "Brings back less than it sets",
        "Tells what it keeps",
    ]


async def test_a_siren_that_not_each_run_turns_on_keeps_no_length() -> None:
    found = await imported("ends_and_events")
    assert [one.name for one in found.refused] == ["Siren in a branch"]


async def test_the_number_of_the_week_in_a_message_is_refused() -> None:
    found = await imported("numbers_and_lengths")
    assert [one.name for one in found.refused] == ["Number of the week"]


async def test_a_list_in_which_unknown_states_count_as_low_is_refused() -> None:
    found = await imported("lists_of_entities")
    assert [one.name for one in found.refused] == ["Unknown ones count as low"]


async def test_a_value_of_another_entity_and_a_limit_of_its_own_are_refused() -> None:
    found = await imported("steps_of_values")
    assert {one.name for one in found.refused} == {"As loud as the other", "Perhaps unknown"}


async def test_a_text_a_remainder_and_two_loops_are_no_number_and_no_list() -> None:
    found = await imported("calculated")
    assert list(dict.fromkeys(one.name for one in found.refused)) == [
        "A text is no number",
        "Calculated and perhaps unknown",
        "Collected in two loops",
        "Two that wait for states",
    ]


def test_each_file_is_also_played_so_that_it_does_nothing_or_less() -> None:
    counts = {name: {len(play.expected) for play in PLAYS if play.name == name} for name, *_ in PLAYS}
    assert len(counts) >= 12
    assert all(min(each) < max(each) for each in counts.values())
