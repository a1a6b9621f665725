"""Imported automations do in a house, in virtual time, what they do in Home Assistant, and nothing more.

What is expected was written after Home Assistant's documentation, and not after what homebot does.
"""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from functools import cache
from typing import Any, NamedTuple

import anyio
import pytest
from tests.integrations.homeassistant.automations.test_automations import HERE, HOUSE, read

from homebot.clock import read_zone
from homebot.devices import Devices
from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest
from homebot.devices.device import Device
from homebot.devices.gateway_messages import Command
from homebot.devices.names import COMMAND_DEVICES
from homebot.devices.value import PlainValue
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.memory import MemoryGateway, MemoryGatewaySettings
from homebot.graph import Node
from homebot.testing import VirtualHouse, virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time]

read_zone("UTC")  # read from the disk before any loop runs
HELPERS: dict[str, Any] = {
    "vacation": False,
    "lux_limit": 30,
    "mode": ["day", "night"],
    "visits": {"counter": 0},
    "oven": {"timer": "10m"},
    "wake_up": {"time": "07:00"},
    **{name: {"button": True} for name in ("good_night", "stop_radio", "keep_heat", "close")},
}
DEVICES = {one.name: one for one in HOUSE if one.endpoints[0].gateway != "helpers"}
FIRST = """
Hall lamp on_off false
Hall lamp level 50
Floor lamp on_off false
Hall motion occupancy false
Hall motion illuminance 10
Hall motion battery 80
Stairs motion occupancy false
Bath window contact false
Bath window battery 80
Front door contact false
Front door lock lock locked
Bath heating heating_setpoint 20
Bath heating thermostat_mode heat
Washer on_off true
Washer power 1
Kitchen plug on_off false
Living blind position 0
Kitchen radio on_off true
Kitchen radio volume 40
Kitchen radio playback stopped
Anna place home
House alarm alarm disarmed
Rosie vacuum docked
Bath climate temperature 20
Bath climate humidity 50
Bath fan on_off false
Bath fan fan_speed 0
Bath leak water_leak false
Weather value sunny
Weather temperature 10
Household at_home true
Household all_at_home true
"""
"""What is so at first, each a device with a capability and its value."""

FILES = ("forum", "asked", "unseen", "kinds", "lasting", "answers", "fresh", "players", "moments")
FRIDAY, SATURDAY = "2026-01-02", "2026-01-03"


class Play(NamedTuple):
    """What happens in the house, and what an automation does then.

    Attributes:
        events: Each a time and a line as in :data:`FIRST`, a helper with a command, or ``topic``, one of MQTT, and a
            message.
        expected: Each the time and a command or message, and at the end the helpers that changed.
        time: The begin and the end.
    """

    automation: str
    events: Sequence[str]
    expected: Sequence[str] = ()
    time: str = "08:00 09:00"
    day: str = FRIDAY


BELL = [
    "08:10:00 Kitchen radio media announce music media-source://media_source/local/Ding Dong.mp3",
    "08:10:00 notify Bell: Somebody rings",
]
MOVED = [
    "08:10 Living blind movement closed",
    "08:15 Bell press single",
    "08:16 Living blind movement opening",
    "08:20 Bell press single",
    "08:21 Living blind movement open",
    "08:25 Bell press single",
]
OPENED = [f"08:{at} Living blind movement {state}" for at, state in (("05", "closed"), ("10", "open"))]
BLINK = [f"08:10:{second} Hall lamp on_off {state}" for second, state in ((30, True), (32, False), (34, True))]
PLAYS: tuple[Play, ...] = (
    Play("Told with its day", ["08:10 Bell press single"],
         ["08:10:00 notify 2026-01-02 08:10:00, 08:10, 2026-01-02 08:10:00"]),
    Play("Told with its day", ["08:10 Hall button press single"]),
    Play("Lamp by messages",
         ['08:10 topic home/remote {"action": "double"}', '08:20 topic home/remote {"action": "off"}',
          '08:30 topic home/remote {"battery": 80}'],
         ["08:10:00 Hall lamp on_off True", "08:20:00 Hall lamp on_off False", "08:30:00 notify Something else"]),
    Play("Lamp by messages", ['08:10 topic home/other {"action": "double"}']),
    Play("Lamp by a knob", ["08:10 topic home/knob right", "08:20 topic home/knob left"],
         ["08:20:00 Hall lamp on_off True"]),
    Play("Lamp by a knob", ["08:10 topic home/knob right"]),
    Play("Noon in the vacation", ["11:10 vacation on"], ["12:00:00 notify Nobody is there", "vacation True"],
         "11:00 13:00"),
    Play("Noon in the vacation", ["12:10 vacation on"], ["vacation True"], "11:00 13:00"),
    Play("Hall is left", ["08:05 Hall lamp on_off true", "08:06 Floor lamp on_off true", "08:10 Bell press single"],
         ["08:10:00 Hall lamp on_off False"]),
    Play("Hall is left", ["08:05 Hall lamp on_off true"]),
    Play("Cleaned", ["08:10 Rosie vacuum cleaning", "08:20 Rosie vacuum docked"],
         ["08:20:00 notify Cleaned 2026-01-02 08:20:00"]),
    Play("Cleaned", ["08:10 Rosie vacuum cleaning"]),
    Play("Clean again", ["08:05 wake_up 2025-12-30 08:55"], ["09:00:00 notify It is time to clean"], "08:00 10:00"),
    Play("Clean again", ["08:05 wake_up 2025-12-30 09:05"], [], "08:00 10:00"),
    Play("Clean again", [], [], "08:00 10:00"),
    Play("Before the alarm", ["08:05 Phone alarm value 2026-01-02T08:40:00+00:00"], ["08:20:00 Hall lamp on_off True"]),
    Play("Before the alarm", ["08:05 Phone alarm value 2026-01-03T08:40:00+00:00"]),
    Play("Bell on the speaker", ["08:10 Bell press double"], BELL),
    Play("Bell on the speaker", ["08:10 Bell press single"]),
    Play("Radio in the morning", [], ["07:00:00 Kitchen radio media http://radio.example/Live.mp3"], "06:50 08:00"),
    Play("Radio in the morning", ["06:55 Household at_home false"], [], "06:50 08:00"),
    Play("Blind in the afternoon sun", [],
         ["07:54:25 Living blind movement closed", "13:57:15 Living blind movement closed"], "06:00 18:00"),
    Play("Blind in the afternoon sun", ["06:10 Weather value rainy"], [], "06:00 18:00"),
    Play("Blind in the afternoon sun", ["06:10 Weather temperature 3"], [], "06:00 18:00"),
    Play("Rain", ["08:10 Weather value pouring"], ["08:10:00 notify It is pouring"]),
    Play("Rain", ["08:10 Weather value partlycloudy"]),
    Play("Button for the blind", MOVED,
         ["08:15:00 Living blind movement open", "08:20:00 Living blind movement stopped",
          "08:25:00 Living blind movement closed"]),
    Play("Button for the blind", MOVED[:1]),
    Play("Still open", ["08:10 Bath window contact true", "08:12 Front door contact true",
                        "08:14 Front door contact false"],
         ["08:15:00 notify Bath window is still open"]),
    Play("Still open", ["08:10 Bath window contact true", "08:12 Front door contact true",
                        "08:14 Bath window contact false"]),
    Play("Door or damp", ["08:10 Front door contact true", "08:20 Bath climate humidity 75"],
         ["08:10:00 notify Front door: open", "08:20:00 notify Bath climate: 75 %"]),
    Play("Door or damp", ["08:20 Bath climate humidity 65"]),
    Play("Plug follows the lamp", ["08:10 Hall lamp on_off true", "08:11 Hall lamp level 20",
                                   "08:12 Hall lamp on_off false"],
         ["08:10:00 notify The lamp was switched", "08:12:00 notify The lamp was switched"]),
    Play("Plug follows the lamp", ["08:11 Hall lamp level 20"]),
    Play("Wait without a door", ["08:10 Hall motion occupancy true"], ["08:11:00 Hall lamp on_off True"]),
    Play("Wait without a door", ["08:10 Hall motion occupancy true", "08:10:30 Front door contact true"]),
    Play("A picture and a song", ["08:10 Bell press single"],
         ["08:10:00 Hall lamp on_off True", "08:10:00 Kitchen radio media a.mp3"]),
    Play("A picture and a song", ["08:10 Hall button press single"]),
    Play("Device action brightness", [], ["21:00:00 Hall lamp level 10", "21:00:00 Hall lamp level 40"], "20:50 21:10"),
    Play("Device action brightness", [], [], "20:50 20:59"),
    Play(
        "Bathroom fan by humidity",
        ["08:10 Bath climate humidity 70", "08:30 Bath climate humidity 50"],
        ["08:15:00 Bath fan fan_speed 70", "08:30:00 Bath fan on_off False"],
    ),
    Play("Bathroom fan by humidity", ["08:10 Bath climate humidity 70"],
         ["08:15:00 Bath fan fan_speed 70", "09:15:00 Bath fan on_off False"], "08:00 10:00"),
    Play("Bathroom fan by humidity", ["08:10 Bath climate humidity 70", "08:14 Bath climate humidity 65"]),
    Play("Doorbell with picture", ["08:10 Bell press single"],
         ["08:10:00 notify Doorbell: Somebody is at the door at 08:10"]),
    Play("Doorbell with picture", ["08:10 Hall button press single"]),
    Play("Freezer door nag", ["08:10 Front door contact true", "08:25 Front door contact false"],
         ["08:13:00 notify Front door is still open", "08:23:00 notify Front door is still open"]),
    Play("Freezer door nag", ["08:10 Front door contact true", "08:12 Front door contact false"]),
    Play("Presence simulation", ["08:05 vacation on"],
         ["16:04:17 Floor lamp on_off True", "16:04:17 Hall lamp on_off True", "16:05:28 Floor lamp on_off False",
          "vacation True"], "08:00 20:00"),
    Play("Presence simulation", [], [], "08:00 20:00"),
    Play("Motion light by time of day", ["08:10 Hall motion occupancy true", "08:12 Hall motion occupancy false"],
         ["08:10:00 Hall lamp color_temperature 4000", "08:10:00 Hall lamp level 100",
          "08:13:30 Hall lamp on_off False"]),
    Play("Motion light by time of day",
         ["23:10 Hall motion occupancy true", "23:12 Hall motion occupancy false", "23:13 Hall motion occupancy true",
          "23:20 Hall motion occupancy false"],
         ["23:10:00 Hall lamp color_temperature 2200", "23:10:00 Hall lamp level 5",
          "23:13:00 Hall lamp color_temperature 2200", "23:13:00 Hall lamp level 5",
          "23:21:30 Hall lamp on_off False"], "23:00 23:50"),
    Play("Motion light by time of day", ["08:05 Hall motion illuminance 40", "08:10 Hall motion occupancy true"]),
    Play("Remote with three presses",
         ["08:10 Hall button press single", "08:11 Hall button press double", "08:12 Hall button press hold"],
         ["08:10:00 Hall lamp on_off True", "08:11:00 Hall lamp level 70", "08:12:00 Floor lamp on_off False",
          "08:12:00 Hall lamp on_off False"]),
    Play("Remote with three presses", ["08:10 Hall button press long", "08:11 Remote press single"]),
    Play("Heating plan", [],
         ["08:15:00 Bath heating heating_setpoint 19", "17:00:00 Bath heating heating_setpoint 21.5",
          "22:30:00 Bath heating thermostat_mode heat", "22:30:00 Bath heating heating_setpoint 17"], "08:00 23:00"),
    Play("Heating plan", [], [], day=SATURDAY),
    Play("Heating plan", ["08:10 Bath heating thermostat_mode off"], [], "08:00 23:00"),
    Play("Last one leaves", ["08:10 Household all_at_home false", "08:20 Household at_home false"],
         ["08:20:00 Floor lamp on_off False", "08:20:00 Hall lamp on_off False", "08:20:00 Rosie vacuum cleaning",
          "08:20:00 House alarm alarm armed_away"]),
    Play("Last one leaves", ["08:10 Household all_at_home false"]),
    Play("Film", ["18:10 Kitchen radio playback playing"],
         ["18:10:10 Hall lamp color (30.0, 84.0)", "18:10:10 Hall lamp level 16"], "18:00 19:00"),
    Play("Film", ["18:10 Kitchen radio playback playing", "18:10:09 Kitchen radio playback paused"], [], "18:00 19:00"),
    Play("Film", ["12:10 Kitchen radio playback playing"], [], "12:00 13:00"),
    Play("Battery report", ["17:30 Bath window battery 14"],
         ["18:00:00 notify Batteries: Hall motion 80 %, bath window 14 %"], "17:00 19:00"),
    Play("Battery report", ["17:30 Bath window battery 15"], [], "17:00 19:00"),
    Play("Forgotten lamp", ["08:10 Hall lamp on_off true"], ["08:45:00 Hall lamp on_off False"]),
    Play("Forgotten lamp",
         ["08:10 Hall lamp on_off true", "08:20 Hall motion occupancy true", "08:41 Hall motion occupancy false"]),
    Play("Leak", ["08:10 Bath leak water_leak true"],
         ["08:10:00 Washer on_off False",
          *(f"08:10:0{second} Hall lamp on_off {state}" for second in (0, 1, 2) for state in (True, False)),
          "08:10:00 notify Water in the bath"]),
    Play("Leak", ["08:10 Bath leak water_leak false"]),
    Play("Wake-up light", [],
         [f"06:2{minute}:00 Hall lamp level {10 * minute or 5}" for minute in range(10)], "06:00 07:00"),
    Play("Wake-up light", ["06:10 Anna place away"], [], "06:00 07:00"),
    Play("Wake-up light", [], [], "06:00 07:00", SATURDAY),
    Play("House helpers", ["08:10 vacation on"],
         ["lux limit 20.0", "mode night", "oven True", "visits 1.0"], "08:00 08:15"),
    Play("House helpers", ["08:10 lux_limit number 51"],
         ["lux limit 20.0", "mode night", "oven True", "visits 2.0"], "08:00 08:21"),
    Play("House helpers", ["08:05 oven on", "08:10 vacation on"], ["oven True", "vacation True"], "08:00 08:11"),
    Play("House helpers", ["08:10 visits number 3", "08:11 vacation on"], ["vacation True", "visits 3.0"]),
    Play("Porch from dusk to eleven", [], ["15:46:06 Hall lamp level 35", "23:00:00 Hall lamp on_off False"],
         "08:00 23:30"),
    Play("Porch from dusk to eleven", [], [], "08:00 15:00"),
    Play("Extractor with two limits",
         [f"08:{at} Bath climate humidity {value}" for at, value in ((10, 70), (20, 59), (21, 61), (30, 59))],
         ["08:10:00 Bath fan on_off True", "08:32:00 Bath fan on_off False"]),
    Play("Extractor with two limits", ["08:10 Bath climate humidity 68", "08:20 Bath climate humidity 60"]),
    Play("Battery of the window", ["08:10 Bath window battery 9"],
         ["09:10:00 notify Bath window has only 9 % left."], "08:00 10:00"),
    Play("Battery of the window", ["08:10 Bath window battery 9", "08:50 Bath window battery 10"], [], "08:00 10:00"),
    Play("Speed by temperature",
         ["08:05 Kitchen plug on_off true",
          *(f"08:{at} Bath climate temperature {value}" for at, value in ((10, 25), (20, 29), (30, 20)))],
         ["08:10:00 Bath fan fan_speed 50", "08:20:00 Bath fan fan_speed 100"]),
    Play("Speed by temperature", ["08:10 Bath climate temperature 25"]),
    Play("Welcome in the dark", ["07:10 Anna place away", "07:20 Anna place home"],
         ["07:20:00 Kitchen radio volume 25", "07:20:00 Movie scene True", "07:20:03 Kitchen radio playback playing"],
         "07:00 08:00"),
    Play("Welcome in the dark", ["12:10 Anna place away", "12:20 Anna place home"], [], "12:00 13:00"),
    Play("Motion with a limit of my own", ["08:10 Stairs motion occupancy true"], ["08:10:00 Hall lamp on_off True"]),
    Play("Motion with a limit of my own", ["08:05 Hall motion illuminance 30", "08:10 Stairs motion occupancy true"]),
    Play("Nobody there", ["08:10 Anna place away"],
         ["08:20:00 Bath heating heating_setpoint 16", "08:20:00 Kitchen radio on_off False"]),
    Play("Nobody there", ["08:10 Anna place away", "08:19 Anna place home"]),
    Play("Nobody there", ["08:05 vacation on", "08:10 Anna place away"], ["vacation True"]),
    Play("Armed", ["08:05 Front door lock lock unlocked", "08:10 House alarm alarm armed_away"],
         ["08:10:00 Front door lock lock locked", "08:10:00 notify The alarm is armed_away"]),
    Play("Armed", ["08:10 House alarm alarm armed_home"]),
    Play("Blink until it is closed", ["08:10 Front door contact true", "08:10:35 Front door contact false"], BLINK),
    Play("Blink until it is closed", ["08:10 Front door contact true", "08:10:29 Front door contact false"]),
    Play("Laundry in two phases",
         [f"{at} Washer power {value}" for at, value in (("08:10", 99), ("08:30", 2), ("08:32", 50), ("09:00", 1))],
         ["09:05:00 notify Laundry: Done at 09:05", "visits 1.0"], "08:00 10:00"),
    Play("Laundry in two phases", ["08:10 Washer power 99"], [], "08:00 13:00"),
    Play("Blind by the hour", [],
         [f"{hour:02}:00:00 Living blind position {30 if hour >= 12 else 100}" for hour in range(9, 19)],
         "08:30 19:30", SATURDAY),
    Play("Blind by the hour", [], [], "08:30 19:30"),
    Play("The plug follows the lamp", ["08:10 Hall lamp on_off true", "08:20 Hall lamp on_off false"],
         ["08:10:00 Kitchen plug on_off True", "08:20:00 Kitchen plug on_off False"]),
    Play("The plug follows the lamp", ["08:10 Hall lamp level 20", "08:20 Floor lamp on_off true"]),
    Play("Mqtt json", ['08:10 topic zigbee2mqtt/Hall button {"action": "double"}'], ["08:10:00 Hall lamp on_off True"]),
    Play("Mqtt json",
         ['08:10 topic zigbee2mqtt/Hall button {"action": "single"}', "08:11 topic zigbee2mqtt/Hall button double"]),
    Play("Lamp follows the window", ["08:10 Bath window contact true", "08:20 Bath window contact false"],
         ["08:10:00 Floor lamp on_off True", "08:20:00 Floor lamp on_off False"]),
    Play("Lamp follows the window", ["08:10 Front door contact true"]),
    Play("Dimmer by its topic", ["08:10 Wall dimmer press single", "08:11 Wall dimmer press double"],
         ["08:10:00 Hall lamp level 90", "08:11:00 Hall lamp on_off False"]),
    Play("Dimmer by its topic", ["08:10 Wall dimmer press long", "08:11 Hall button press single"]),
    Play("White by the hour", ["08:10 Hall lamp on_off true"], ["08:10:00 Hall lamp color_temperature 2200"]),
    Play("White by the hour", ["18:10 Hall lamp on_off true"], ["18:10:00 Hall lamp color_temperature 3000"],
         "18:00 19:00"),
    Play("White by the hour", ["08:10 Floor lamp on_off true"]),
    Play("Leak told and shown", ["08:10 Bath leak water_leak true"],
         ["08:10:05 notify House: Bath leak at 08:10",
          *(f"08:10:{second} Hall lamp on_off {state}" for second, state in
            (("05", True), ("06", False), ("07", True), ("08", False)))]),
    Play("Leak told and shown", ["08:05 Hall lamp on_off true", "08:10 Bath leak water_leak true"],
         ["08:10:05 notify House: Bath leak at 08:10",
          *(f"08:10:{second} Hall lamp on_off {state}" for second, state in
            (("05", True), ("06", False), ("07", True), ("08", False), ("09", True)))]),
    Play("Leak told and shown", ["08:10 Bath leak water_leak true", "08:10:03 Bath leak water_leak false"]),
    Play("Reminder until it is closed", ["08:10 Front door contact true", "08:25 Front door contact false"],
         ["08:13:00 notify The door is open.", "08:23:00 notify Still open, reminder 2."]),
    Play("Reminder until it is closed", ["08:10 Front door contact true"],
         ["08:13:00 notify The door is open.", *(f"08:{at}:00 notify Still open, reminder {number}."
          for at, number in ((23, 2), (33, 3)))]),
    Play("Reminder until it is closed", ["08:10 Front door contact true", "08:12 Front door contact false"]),
    Play("Fan by a difference", ["08:10 Bath climate humidity 66", "08:20 Bath climate humidity 54"],
         ["08:10:00 Bath fan fan_speed 70", "08:25:00 Bath fan on_off False"]),
    Play("Fan by a difference", ["08:10 Bath climate humidity 64"]),
    Play("Blind not before its hour", [],
         ["07:00:00 Living blind movement open", "08:30:00 Living blind movement open"], "06:50 09:00"),
    Play("Blind not before its hour", ["06:55 vacation on"],
         ["08:30:00 Living blind movement open", "vacation True"], "06:50 09:00"),
    Play("Blind not before its hour", ["06:55 vacation on"], ["vacation True"], "06:50 08:00"),
    Play("One of two reasons", ["08:10 Bath leak water_leak true"], ["08:10:00 notify Bath: water"]),
    Play("One of two reasons", ["08:10 Bath climate humidity 71"], ["08:10:00 notify Bath: 71 %"]),
    Play("One of two reasons", ["08:10 Bath climate humidity 69"]),
    Play("The limit that was passed", ["08:10 Bath climate humidity 61", "08:20 Bath climate humidity 39"],
         ["08:10:00 Bath fan on_off True", "08:20:00 Bath fan on_off False"]),
    Play("The limit that was passed", ["08:10 Bath climate humidity 59"]),
    Play("All lights white", ["08:10 Stairs motion occupancy true"],
         ["08:10:00 Floor lamp on_off True", "08:10:00 Hall lamp level 100",
          "08:10:00 Hall lamp color_temperature 5000"]),
    Play("All lights white", ["08:10 Hall motion occupancy true"]),
    Play("Eco or comfort", ["08:10 Household at_home false", "08:40 Household at_home true"],
         ["08:25:00 Bath heating heating_setpoint 16", "08:40:00 Bath heating heating_setpoint 30"]),
    Play("Eco or comfort", ["08:10 Household at_home false", "08:20 Household at_home false"],
         ["08:25:00 Bath heating heating_setpoint 16"]),
    Play("Motion light by variables", ["08:10 Hall motion occupancy true", "08:12 Hall motion occupancy false"],
         ["08:10:00 Hall lamp level 80", "08:15:00 Hall lamp on_off False"]),
    Play("Two speeds by the hour", ["08:10 Bath climate humidity 61"], ["08:10:00 Bath fan fan_speed 20"]),
    Play("Two speeds by the hour", ["09:10 Bath climate humidity 61"], ["09:10:00 Bath fan fan_speed 70"],
         "09:00 10:00"),
    Play("Two speeds by the hour", ["08:10 Bath climate humidity 60"]),
    Play("Motion light by variables", ["08:05 Hall motion illuminance 15", "08:10 Hall motion occupancy true"]),
    Play("Windows at ten", ["09:10 Bath window contact true", "09:20 Front door contact true"],
         ["10:00:00 notify Open: Bath window, Front door"], "09:00 10:10"),
    Play("Windows at ten", ["09:10 Bath window contact true", "09:20 Bath window contact false"],
         ["10:00:00 notify All closed"], "09:00 10:10"),
    Play("Windows at ten", [], [], "09:00 09:50"),
    Play("Low batteries", ["09:10 Bath window battery 9"], ["10:00:00 notify Bath window 9 %"], "09:00 10:10"),
    Play("Low batteries", ["09:10 Bath window battery 9", "09:20 Bath window contact true"], [], "09:00 10:10"),
    Play("Shutter by azimuth", ["11:10 Bath climate temperature 23"], ["11:32:02 Living blind position 30"],
         "11:00 12:00"),
    Play("Shutter by azimuth", ["11:10 Bath climate temperature 22"], [], "11:00 12:00"),
    Play("Ten minutes without motion",
         ["08:05 Hall lamp on_off true", "08:20 Hall motion occupancy true", "08:22 Hall motion occupancy false"],
         ["08:15:00 Hall lamp on_off False"]),
    Play("Ten minutes without motion",
         ["08:05 Hall lamp on_off true", "08:07 Hall motion occupancy true", "08:25 Hall motion occupancy false"],
         ["08:45:00 Hall lamp on_off False"]),
    Play("Ten minutes without motion", ["08:07 Hall motion occupancy true", "08:25 Hall motion occupancy false"]),
    Play("Just came in", ["08:10 Front door contact true", "08:11:59 Hall motion occupancy true"],
         ["08:11:59 Floor lamp on_off True"]),
    Play("Just came in", ["08:10 Front door contact true", "08:12 Hall motion occupancy true"]),
    Play("Off after my own minutes",
         ["08:02 lux_limit number 15", "08:05 Stairs motion occupancy true", "08:10 Stairs motion occupancy false"],
         ["08:25:00 Hall lamp on_off False", "lux limit 15.0"]),
    Play("Off after my own minutes",
         ["08:02 lux_limit number 15", "08:05 Stairs motion occupancy true", "08:10 Stairs motion occupancy false",
          "08:20 Stairs motion occupancy true"], ["lux limit 15.0"]),
    Play("Player fell silent",
         ["08:05 Kitchen radio playback playing", "08:10 Kitchen radio playback stopped"],
         ["08:15:00 Kitchen plug on_off False"]),
    Play("Player fell silent",
         ["08:05 Kitchen radio playback playing", "08:10 Kitchen radio playback stopped",
          "08:14 Kitchen radio playback playing"]),
    Play("Player fell silent",
         ["08:05 Kitchen radio playback paused", "08:10 Kitchen radio playback stopped"]),
    Play("Docked after cleaning",
         ["08:05 Rosie vacuum cleaning", "08:10 Rosie vacuum returning", "08:12 Rosie vacuum docked"],
         ["08:13:00 notify Rosie was out for 0:01:00 less"]),
    Play("Docked after cleaning",
         ["08:05 Rosie vacuum cleaning", "08:10 Rosie vacuum docked", "08:20 Rosie vacuum returning",
          "08:22 Rosie vacuum docked", "08:22:30 Rosie vacuum cleaning"]),
    Play("All still",
         ["08:05 Stairs motion occupancy true", "08:10 Hall motion occupancy true", "08:12 Hall motion occupancy false",
          "08:15 Stairs motion occupancy false"],
         ["08:10:00 Hall lamp on_off True", "08:15:00 Hall lamp on_off False"]),
    Play("All still", ["08:05 Stairs motion occupancy true", "08:10 Hall motion occupancy true"],
         ["08:10:00 Hall lamp on_off True", "08:40:00 Hall lamp on_off False"]),
    Play("All still", ["08:05 Stairs motion occupancy true", "08:10 Hall motion occupancy true"],
         ["08:10:00 Hall lamp on_off True"], "08:00 08:39"),
    Play("Quiet hours of my own", ["08:10 Bell press single"], ["08:10:00 notify Somebody rings"]),
    Play("Quiet hours of my own", ["08:05 wake_up 08:30", "08:10 Bell press single"]),
    Play("Good night button", ["08:10 good_night push", "08:20 good_night push"],
         ["08:10:00 Floor lamp on_off False", "08:10:00 Hall lamp on_off False"]),
    Play("Good night button", ["08:10 vacation on"], ["vacation True"]),
    Play("Ask for the radio", ["08:10 Front door contact true"],
         ["08:15:00 notify Door: The front door is open [stop radio]"]),
    Play("Ask for the radio", ["08:10 Front door contact true", "08:14 Front door contact false"]),
    Play("Radio by an answer", ["08:10 stop_radio push"], ["08:10:00 Kitchen radio on_off False"]),
    Play("Radio by an answer", ["08:10 keep_heat push"]),
    Play("Ask and wait", ["08:10 Bath window contact true"],
         ["08:10:00 notify The bath window is open [keep heat]", "08:20:00 Bath heating thermostat_mode off"]),
    Play("Ask and wait", ["08:10 Bath window contact true", "08:15 keep_heat push"],
         ["08:10:00 notify The bath window is open [keep heat]"]),
    Play("Blind left open", [*OPENED, "08:22 close push"],
         ["08:20:00 notify Close it? [close]", "08:22:00 Living blind movement closed"]),
    Play("Blind left open", [*OPENED, "08:26 close push"],
         ["08:20:00 notify Close it? [close]"]),
    Play("Run another", ["08:10 Bell press single"], ["08:10:00 Hall lamp on_off True"]),
    Play("Run another", ["08:10 stop_radio push"]),
    Play("Publish to a device", ["08:10 Stairs motion occupancy true"],
         ["08:10:00 Hall lamp level 50", "08:11:00 Hall lamp on_off False"]),
    Play("Publish to a device", ["08:10 Stairs motion occupancy false"]),
    Play("Sleep mode", ["08:10 mode option night"],
         ["08:10:00 Bath heating heating_setpoint 17", "08:10:00 Floor lamp on_off False",
          "08:10:00 Front door lock lock locked", "08:10:00 Hall lamp on_off False", "mode night"]),
    Play("Sleep mode", ["08:10 vacation on"], ["vacation True"]),
    Play("Auto away", ["08:10 Household at_home false"],
         ["08:20:00 notify Nobody is at home, mode night", "mode night"]),
    Play("Auto away", ["08:10 Household at_home false", "08:15 Household at_home true"]),
    Play("Somebody seems to be there", ["21:55 vacation on"],
         ["22:03:25 Floor lamp on_off True", "22:41:44 Hall lamp on_off True", "vacation True"], "21:50 22:50"),
    Play("Somebody seems to be there", ["23:05 vacation on"], ["vacation True"], "22:50 23:50"),
    Play("Laundry with a timer",
         ["08:10 Washer power 99", "08:30 Washer power 1", "09:10 Bath window contact true"],
         ["08:32:00 notify Laundry: Please empty it (quiet)", "09:02:00 notify Laundry: Please empty it (again)"],
         "08:00 10:00"),
    Play("Laundry with a timer", ["08:10 Washer power 99", "08:11 vacation off", "08:30 Washer power 1"]),
    Play("Bins every other week", [],
         [f"{at}:00 notify Put the brown bin out" for at in ("19:00", "19:20", "19:40", "20:00", "20:20", "20:40")],
         "18:50 21:30", "2026-01-06"),
    Play("Bins every other week", ["19:25 Front door contact true"],
         [f"{at}:00 notify Put the brown bin out" for at in ("19:00", "19:20")], "18:50 21:30", "2026-01-06"),
    Play("Bins every other week", [], [], "18:50 21:30", "2026-01-13"),
    Play("Gate opens",
         [f"08:{at} Front door contact {state}" for at, state in (("10", "true"), ("12", "false"), ("13", "true"))],
         ["08:10:03 notify The gate is open"]),
    Play("Gate opens", ["08:10:00 Front door contact true", "08:10:02 Front door contact false"]),
    Play("Lights of the season", [], ["15:26:06 Kitchen plug on_off True", "23:00:00 Kitchen plug on_off False"],
         "08:00 23:30"),
    Play("Lights of the season", [], [], "08:00 23:30", "2026-02-02"),
    Play("Door open too long", ["08:10 Front door contact true", "08:22 keep_heat push"],
         ["08:20:00 notify The door is open. What now? [stop radio] [keep heat]",
          "08:22:00 Bath heating thermostat_mode heat"]),
    Play("Door open too long", ["08:10 Front door contact true", "08:22 stop_radio push"],
         ["08:20:00 notify The door is open. What now? [stop radio] [keep heat]",
          "08:22:00 Kitchen radio playback stopped"]),
    Play("Door open too long", ["08:10 Front door contact true", "08:36 stop_radio push"],
         ["08:20:00 notify The door is open. What now? [stop radio] [keep heat]"]),
    Play("Weak batteries", ["09:30 Bath window battery 10"],
         ["10:00:00 notify Weak: 80 % in the hall, 10 % in the bath"], "09:00 11:00"),
    Play("Weak batteries", ["09:30 Bath window battery 20"], [], "09:00 11:00"),
    Play("Warm bath", ["08:10 vacation on", "08:20 vacation off"],
         [f"{at}:00 Bath heating heating_setpoint {value}"
          for at, value in (("07:00", 22), ("08:10", 12), ("08:20", 18), ("09:00", 18))], "06:50 09:30"),
    Play("Warm bath", [], [], "08:00 08:30"),
    Play("Bell while music plays",
         ["08:05 Kitchen radio playback playing", "08:10 Bell press single", "08:10:20 Bell press single"],
         ["08:10:00 Kitchen radio volume 20", "08:10:00 notify Somebody is at the door",
          "08:10:05 Kitchen radio volume 40"]),
    Play("Bell while music plays", ["08:10 Bell press single"]),
    Play("Alarm light",
         ["08:05 House alarm alarm armed_away", "08:10 House alarm alarm triggered",
          "08:10:03 House alarm alarm disarmed"],
         ["08:10:00 notify Alarm: The alarm went from armed_away to triggered!",
          "08:10:00 Hall lamp on_off True", "08:10:02 Hall lamp on_off False"]),
    Play("Alarm light", ["08:05 House alarm alarm armed_away"]),
    Play("Back from vacation", ["08:10 wake_up 2026-01-02T08:30:00"],
         ["08:30:00 Bath heating heating_setpoint 21"]),
    Play("Back from vacation", ["08:10 wake_up 2026-01-03 08:30"]),
    Play("Back from vacation", ["08:10 wake_up 2026-01-02"]),
    Play("Dryer by power with helper", ["08:10 Washer power 99", "08:30 Washer power 2"],
         ["08:33:00 notify Dryer done at 08:33"]),
    Play("Dryer by power with helper", ["08:10 Washer power 99"], ["mode night"]),
    Play("Dryer by power with helper", ["08:10 Washer power 99", "08:10:30 Washer power 8", "08:30 Washer power 2"]),
    Play("Next mode", ["08:10 Bell press single"],
         ["08:10:00 Kitchen radio playback playing", "mode night"]),
    Play("Next mode", ["08:10 Bell press single", "08:20 Bell press single"],
         ["08:10:00 Kitchen radio playback playing", "08:20:00 Kitchen radio playback paused"]),
    Play("Next mode", ["08:10 Hall button press single"]),
    Play("Longer on vacation", ["08:10 Front door contact true"],
         ["08:20:00 notify The door was off, and is open for 0:10:00"]),
    Play("Longer on vacation", ["08:05 vacation on", "08:10 Front door contact true"],
         ["08:12:00 notify The door was off, and is open for 0:02:00", "vacation True"]),
    Play("Longer on vacation", ["08:10 Front door contact true", "08:19 Front door contact false"]),
)  # fmt: skip


class PlayedGateway(MemoryGateway):
    """Records each command with its time; what has a speed is on."""

    def __init__(self, node: Node) -> None:
        super().__init__(node, MemoryGatewaySettings(act=True))
        self.done: list[tuple[float, str]] = []

    async def _perform(self, command: Command) -> None:
        await super()._perform(command)
        value = command.value.plain()
        if command.capability == "fan_speed":
            await self.devices.report(command.key, {"on_off": value != 0.0}, command.part)
        text = f"{value:.4g}" if isinstance(value, float) else str(value)
        self.done.append((self.node.graph.clock.now(), f"{command.key} {command.capability} {text}"))

    async def tell(self, line: str) -> None:
        """Report a value as its device."""
        name = max((name for name in DEVICES if line.startswith(f"{name} ")), key=len)
        capability, _, text = line.removeprefix(f"{name} ").partition(" ")
        value: PlainValue = float(text) if text.isdecimal() else {"true": True, "false": False}.get(text, text)
        for part in DEVICES[name].parts:
            if capability in {can.name for can in part.part.capabilities}:
                await self.devices.report(name, {capability: value}, part.id)


@cache
def text(name: str) -> str:
    return (HERE / f"{name}.yaml").read_text()


@cache
def routines(name: str) -> Mapping[str, dict[str, Any]]:
    """Return the routines of a file by name."""
    return {table["name"]: table for one in read(text(name)).texts for table in tomllib.loads(one)["routines"]}


def routine(automation: str) -> dict[str, Any]:
    """Return a routine of the last file that has it: to read all of them takes as long as several plays."""
    return routines([name for name in FILES if f"alias: {automation}\n" in text(name)][-1])[automation]


def described(device: Device) -> GatewayDevice:
    facts = {fact.name: fact.value for fact in device.facts}
    return GatewayDevice(device.name, device.name, tuple(one.part for one in device.parts), facts, area=device.area)


async def happens(event: str, house: VirtualHouse, gateway: PlayedGateway) -> None:
    at, _, line = event.partition(" ")
    await house.run_until(at)
    first, _, rest = line.partition(" ")
    if first == "topic":
        topic, brace, payload = rest.partition(" {")
        await house.says(*((topic, f"{{{payload}") if brace else rest.rsplit(" ", 1)))
    elif first in HELPERS:
        commands = gateway.node.create_client(CommandDevices, COMMAND_DEVICES)
        assert (await commands.call(CommandDevicesRequest(target=first, command=rest))).success
    else:
        await gateway.tell(line)


async def changed_helpers(node: Node) -> list[str]:
    first = {"vacation": False, "lux limit": 30.0, "mode": "day", "visits": 0.0, "oven": False}
    found = {one.name: one.states[0].value.plain() for one in await Devices(node).find() if one.name in first}
    return sorted(f"{name} {value}" for name, value in found.items() if value != first[name])


def stamped(lines: Sequence[tuple[float, str]]) -> Iterator[str]:
    for at, text in lines:
        yield f"{datetime.fromtimestamp(at, UTC):%H:%M:%S} {text}"


@pytest.mark.parametrize("play", PLAYS, ids=lambda play: f"{play.automation}, {len(play.expected)}")
async def test_an_automation_does_in_the_house_what_it_did(play: Play) -> None:
    home = {"zone": "UTC", "latitude": 48.0, "longitude": 8.0}
    config = {"routines": [routine(play.automation)], "home": home, "helpers": HELPERS, "notify": {}}
    begin, end = play.time.split()
    async with (
        virtual_house_of(config=config, start=f"{play.day} {begin}") as house,
        Node(house.runtime.graph, "homeassistant", namespace="/gateway") as node,
        anyio.create_task_group() as tasks,
    ):
        gateway = PlayedGateway(node)
        await tasks.start(gateway.serve)
        for device in DEVICES.values():
            gateway.devices.put(described(device), "it is played")
        for line in FIRST.strip().splitlines():
            await gateway.tell(line)
        await house.run_for("30s")
        for event in play.events:
            await happens(event, house, gateway)
        await house.run_until(end)
        helpers = await changed_helpers(node)
        told = [
            (one.time.timestamp(), f"notify {one.message}")
            for one in house.notifications
            if not one.app.endswith("alerts")
        ]
        tasks.cancel_scope.cancel()
    assert [*sorted(stamped([*gateway.done, *told])), *helpers] == sorted(play.expected)


def test_each_automation_is_also_played_so_that_it_does_nothing_or_less() -> None:
    counts = {name: {len(play.expected) for play in PLAYS if play.automation == name} for name, *_ in PLAYS}
    assert len(counts) >= 25
    assert all(len(each) > 1 for each in counts.values())
