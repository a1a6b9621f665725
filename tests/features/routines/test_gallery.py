"""The gallery: each ready-made routine in a house in which somebody lives for four weeks."""

import asyncio
import json
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime, timedelta
from typing import Final

import pytest
from tests.apps.houses import flat, lamp
from tests.replay.recorded_days import MemorySink, recording_of
from tests.sizes import size

from homebot.apps.notifier import Notification
from homebot.cli.main import main
from homebot.devices.query.terms import TypeIs, leaves
from homebot.features.routines.gallery import gallery, ready_made
from homebot.features.routines.text import read_routines
from homebot.house import World
from homebot.support.virtual_time import VirtualTimeLoop
from homebot.testing import virtual_house_of
from homebot.words.queries import parse_query

pytestmark = [pytest.mark.slow, pytest.mark.rooms("homeassistant")]

THURSDAY: Final = datetime(2026, 1, 8, tzinfo=UTC)
DAYS: Final = size(usual=4, nightly=28)
HOME: Final = [day not in {2, 3, *range(21, 28)} for day in range(DAYS)]
OUT: Final = [is_home and day % 7 in {0, 4, 5, 6} for day, is_home in enumerate(HOME)]
"""Whether Kim works elsewhere that day: on Fridays at home."""

ANNOUNCED: Final[Mapping[str, dict[str, object]]] = {
    "device_tracker/kim": {"name": "Kim's phone"},
    "event/bed": {"name": "Bed button", "device_class": "button", "event_types": ["single"]},
    "event/bell": {"name": "Bell", "device_class": "doorbell", "event_types": ["single"]},
    "binary_sensor/motion": {"name": "Hall motion", "device_class": "motion"},
    "binary_sensor/door": {"name": "Front door", "device_class": "door"},
    "binary_sensor/window": {"name": "Study window", "device_class": "window"},
    "binary_sensor/garage": {"name": "Garage", "device_class": "garage_door"},
    "binary_sensor/leak": {"name": "Cellar", "device_class": "moisture"},
    "sensor/lux": {"name": "Hall brightness", "device_class": "illuminance", "unit_of_measurement": "lx"},
    "sensor/washer": {"name": "Washer", "device_class": "power", "unit_of_measurement": "W"},
    "sensor/mains": {"name": "Mains", "device_class": "power", "unit_of_measurement": "W"},
    "sensor/tv": {"name": "TV", "device_class": "power", "unit_of_measurement": "W"},
    "sensor/freezer": {"name": "Freezer", "device_class": "temperature", "unit_of_measurement": "°C"},
    "sensor/outside": {"name": "Garden", "device_class": "temperature", "unit_of_measurement": "°C"},
    "sensor/inside": {"name": "Living air", "device_class": "temperature", "unit_of_measurement": "°C"},
    "sensor/bath": {"name": "Bath air", "device_class": "humidity", "unit_of_measurement": "%"},
    "sensor/plant": {"name": "Ficus", "device_class": "moisture", "unit_of_measurement": "%"},
    "fan/fan": {"name": "Bath fan", "command_topic": "fan"},
    "switch/plug": {"name": "TV plug", "device_class": "outlet", "command_topic": "plug"},
    "vacuum/vacuum": {"name": "Robbie", "command_topic": "vacuum/do", "supported_features": ["start", "return_home"]},
}
CHOSEN: Final[Mapping[str, Mapping[str, str]]] = {
    "motion_light": {"motion": "hall motion", "lamp": "hall lamp", "light_sensor": "hall brightness"},
    "night_light": {"motion": "hall motion", "lamp": "path lamp"},
    "welcome_light": {"door": "front door", "lamp": "porch lamp"},
    "lights_off_when_away": {},
    "button_light": {"button": "bed button", "lamp": "bed lamp"},
    "wake_up_light": {"lamp": "wake lamp"},
    "evening_lights": {"lamp": "living lamp"},
    "presence_simulation": {"lamp": "study lamp", "other": "kitchen lamp"},
    "good_night": {"button": "bed button", "door": "study window"},
    "heating_window": {"window": "study window", "heater": "study heater"},
    "heating_times": {"heater": "living heater"},
    "heating_night": {"heater": "living heater"},
    "heating_away": {"heater": "hall heater"},
    "window_forgotten": {"window": "study window", "outside": "garden"},
    "garage_left_open": {"garage": "garage"},
    "door_opened_away": {"door": "front door"},
    "doorbell": {"bell": "bell", "lamp": "porch lamp"},
    "laundry_done": {"meter": "washer"},
    "freezer_warm": {"freezer": "freezer"},
    "plant_dry": {"plant": "ficus"},
    "power_high": {"meter": "mains"},
    "standby_off": {"plug": "'tv plug'", "meter": "tv"},
    "bath_fan": {"sensor": "bath air", "fan": "bath fan"},
    "shutters": {"shutter": "living shutter"},
    "shade": {"shutter": "study shutter", "inside": "living air"},
    "vacuum_when_away": {"vacuum": "robbie"},
    "water_leak": {"leak": "cellar", "lamp": "path lamp"},
}
ALERTS: Final = [
    "smoke",
    "co",
    "gas",
    "leak",
    "alarm",
    "tamper",
    "gateway",
    "problem",
    "door",
    "unreachable",
    "silent",
    "battery",
]
ROOMS: Final = ("hall", "study", "living")
LAMPS: Final = (
    "hall_lamp",
    "path_lamp",
    "porch_lamp",
    "bed_lamp",
    "wake_lamp",
    "living_lamp",
    "study_lamp",
    "kitchen_lamp",
)


PRESSED: Final = '{"event_type": "single"}'
DOCKED: Final = '{"state": "docked"}'


def day_of(day: int) -> Iterator[tuple[str, str, str]]:
    """Yield what happens in a day, by time and topic."""
    yield from (("08:00", "lux", "400"), ("16:00", "lux", "10"), ("00:10", "tv", "4"), ("19:00", "tv", "90"))
    yield from (("06:00", "plant", str(25 - 6 * day % 24)), ("03:00", "freezer", "-19"), ("03:00", "outside", "3"))
    yield from (("03:00", topic, "OFF") for topic in ("door", "window", "garage", "leak", "fan", "plug"))
    yield "03:00", "vacuum", DOCKED
    if not HOME[day]:
        yield "12:00", "kim", "not_home"
    else:
        yield from (("06:40", "motion", "ON"), ("06:44", "motion", "OFF"), ("07:00", "bath", "72"))
        yield from (("07:10", "window", "ON"), ("07:38", "window", "OFF"), ("07:40", "bath", "50"))
        yield from (("21:00", "motion", "ON"), ("21:05", "motion", "OFF"), ("22:45", "bed", PRESSED))
        yield from (("23:30", "motion", "ON"), ("23:31", "motion", "OFF"), ("23:00", "kim", "home"))
    if OUT[day]:
        yield from (("07:44", "door", "ON"), ("07:45", "door", "OFF"), ("07:50", "kim", "not_home"))
        yield from (("17:02", "garage", "ON"), ("17:04", "garage", "OFF"), ("17:05", "kim", "home"))
        yield from (("17:06", "door", "ON"), ("17:07", "door", "OFF"))


ONCE: Final = (
    (0, "18:00", "garage", "ON"),
    (0, "20:30", "garage", "OFF"),
    (1, "10:00", "washer", "500"),
    (1, "11:30", "washer", "2"),
    (1, "12:00", "mains", "4000"),
    (1, "12:30", "mains", "700"),
    (1, "18:00", "mains", "4000"),
    (1, "18:05", "mains", "500"),
    (1, "13:00", "freezer", "-11"),
    (1, "15:00", "freezer", "-19"),
    (1, "14:00", "inside", "27"),
    (1, "17:00", "inside", "22"),
    (1, "19:00", "bell", PRESSED),
    (1, "20:00", "leak", "ON"),
    (2, "00:30", "kim", "not_home"),  # a journey
    (3, "13:00", "door", "ON"),
    (3, "13:10", "door", "OFF"),
    (4, "00:30", "kim", "home"),
    (21, "00:30", "kim", "not_home"),
)
FIRST: Final = {
    **dict.fromkeys(("motion", "door", "window", "garage", "leak", "fan", "plug"), "OFF"),
    "kim": "home",
    "lux": "10",
    "washer": "20",
    "mains": "400",
    "tv": "4",
    "freezer": "-19",
    "outside": "3",
    "inside": "20",
    "bath": "50",
    "plant": "40",
    "vacuum": DOCKED,
}


def world() -> World:
    lamps = {name: lamp("hall") for name in LAMPS}
    heaters = {f"{room}_heater": {"kind": "thermostat", "room": "hall", "target": 21.0} for room in ROOMS}
    shutters = {f"{room}_shutter": {"kind": "cover", "room": "hall", "is_open": True} for room in ROOMS[1:]}
    return flat(by_hand=True, **lamps, **heaters, **shutters)


@pytest.fixture(scope="module")
def lived() -> Mapping[str, tuple[int, int]]:
    texts = {name: ready_made(name).filled(said) for name, said in CHOSEN.items()}
    apps = {name: read_routines(text, name)[0].app for name, text in texts.items()}
    config = tomllib.loads("".join(texts.values())) | {
        "home": {"zone": "UTC", "latitude": 52.5, "longitude": 13.4},
        "alerts": dict.fromkeys(ALERTS, False),
        "people": {"Kim": {"trackers": ["Kim's phone"]}},
    }
    sink, told = MemorySink(), list[Notification]()

    async def live() -> None:
        async with virtual_house_of(
            world=world(), config=config, start=f"{THURSDAY:%Y-%m-%d}", observers=sink.observers()
        ) as house:
            for name, announced in ANNOUNCED.items():
                topic = name.partition("/")[2]
                fields = {"state_topic": topic, "unique_id": topic, **announced}
                await house.says(f"homeassistant/{name}/config", json.dumps(fields))
            await house.run_for("1m")
            for topic, text in FIRST.items():
                await house.says(topic, text)
            events = [(day, *event) for day in range(DAYS) for event in day_of(day)]
            events += [event for event in ONCE if event[0] < DAYS]
            for day, at, topic, text in sorted(events):
                hours, minutes = map(int, at.split(":"))
                await house.run_until(THURSDAY + timedelta(days=day, hours=hours, minutes=minutes))
                await house.says(topic, text)
            await house.run_until(THURSDAY + timedelta(days=DAYS))
            told.extend(house.notifications)

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(live())
    commands = Counter(one.command.issuer.removeprefix("/") for one in recording_of(sink.lines).commands)
    messages = Counter(one.app for one in told)
    return {name: (commands[app], messages[app]) for name, app in apps.items()}


def test_each_does_its_work_in_four_weeks_and_no_more(lived: Mapping[str, tuple[int, int]]) -> None:
    """Commands and messages; four days alone, except in ``make nightly``."""
    home, out, weekdays = sum(HOME), sum(OUT), sum(day % 7 not in {2, 3} for day in range(DAYS))
    mornings = sum(is_home and day % 7 not in {2, 3} for day, is_home in enumerate(HOME))
    evenings = sum(HOME) - sum(OUT)  # Kim is there at dusk
    journeys = 2 if DAYS > 4 else 1
    commands, _ = lived["presence_simulation"]  # at random times, also on days when Kim comes home after dusk
    assert 4 * (DAYS - home) <= commands <= 4 * (DAYS - home + out)
    assert {name: one for name, one in lived.items() if name != "presence_simulation"} == {
        "motion_light": (6 * home, 0),
        "night_light": (2 * home, 0),
        "welcome_light": (2 * out, 0),
        "lights_off_when_away": (len(LAMPS) * (out + journeys), 0),
        "button_light": (home, 0),
        "wake_up_light": (20 * mornings, 0),
        "evening_lights": (evenings, 0),
        "good_night": (len(LAMPS) * home, 0),
        "heating_window": (2 * home, 0),
        "heating_times": (2 * weekdays, 0),
        "heating_night": (DAYS, 0),
        "heating_away": (2 * out + 2 * journeys - 1, 0),
        "window_forgotten": (0, home),
        "garage_left_open": (0, 3),
        "door_opened_away": (0, 1),
        "doorbell": (2, 1),
        "laundry_done": (0, 1),
        "freezer_warm": (0, 1),
        "plant_dry": (0, DAYS // 4),
        "power_high": (0, 1),
        "standby_off": (DAYS, 0),
        "bath_fan": (2 * home, 0),
        "shutters": (2 * DAYS - 1, 0),
        "shade": (2, 0),
        "vacuum_when_away": (out, 0),
        "water_leak": (1, 1),
    }


def test_the_gallery_is_listed_and_a_routine_is_printed_with_the_devices(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["routine", "gallery"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()[1:]] == sorted(CHOSEN)
    assert main(["routine", "gallery", "night_light"]) == 0
    listed = capsys.readouterr().out
    assert "homebot find 'motion sensors'" in listed
    assert "22:30" in listed
    assert main(["routine", "gallery", "night_light", "motion=hall motion", "lamp='hall lamp'", "begins=23:00"]) == 0
    text = capsys.readouterr().out
    assert 'name = "Night light: hall lamp"' in text
    assert read_routines(text, "")[0].table["if"] == ["between 23:00 and 6:00", "not 'hall lamp' on"]


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["night_ligt"], "there is no ready-made routine 'night_ligt'; did you mean night_light"),
        (["night_light", "motin=hall motion"], "there is no input 'motin'; did you mean motion?"),
        (["night_light", "motion=hall motion"], "say which: lamp=NAME; `homebot find lights` lists what fits"),
        (["night_light", "hall"], "'hall' is no input; write it like lamp='hall lamp'"),
    ],
)
def test_a_wrong_input_of_the_gallery_is_told(
    words: list[str], problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["routine", "gallery", *words]) == 1
    assert problem in capsys.readouterr().err


def test_the_devices_of_every_input_are_words_that_find_knows() -> None:
    for name, routine in gallery().items():
        for key, said in routine.inputs.items():
            assert bool(said.find) is not bool(said.default), (name, key)
            if said.find:
                assert any(isinstance(term, TypeIs) for term in leaves(parse_query(said.find))), (name, key)
