"""Alerts: what is wrong in the house is told to people once, with its end, and shown as long as it lasts."""

import json
import math
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from itertools import groupby, pairwise
from pathlib import Path
from random import Random
from typing import get_args

import anyio
import pytest
from tests.sizes import size
from tests.web.test_languages import TABLE
from tests.whole_house import WHOLE_HOUSE

from homebot.clock import LoopClock
from homebot.config import AlertKey, parse_config
from homebot.devices.capabilities import ALERTING, CAPABILITIES, SETTABLE
from homebot.devices.findings import Finding, Findings
from homebot.devices.gateway_messages import GatewayState, RawCommand
from homebot.devices.names import ALERT_FINDINGS, OPEN_QUESTIONS, GatewayNames
from homebot.devices.question_messages import OpenQuestion, OpenQuestions
from homebot.errors import ConfigError
from homebot.features.alerts import SEE_ALERTS
from homebot.features.alerts.alert_table import ALERTS, GATEWAY, LANGUAGES, WATCHED, Alert, AlertKind
from homebot.features.alerts.alerts import MAX_INCIDENTS, update_incidents
from homebot.graph import Node, qos_profile_latched
from homebot.house import World
from homebot.house.description import load_world
from homebot.house.event_log import Event
from homebot.house.rooms import DAY
from homebot.messages import Time
from homebot.messages.std_srvs import Trigger, TriggerRequest
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime
from homebot.runtime.plan import make_plan
from homebot.testing import VirtualHouse, virtual_house_of

pytestmark = pytest.mark.virtual_time

HOUSES = Path(__file__).parents[3] / "examples" / "houses"
NEVER = Time(sec=0, nanosec=0)
NOTIFY: dict[str, dict[str, object]] = {"notify": {}}


SINK = json.dumps(
    {
        "name": "Sink",
        "unique_id": "sink",
        "device_class": "tamper",
        "state_topic": "home/sink",
    }
)


DETAILS = (
    (" ({charge} %)", "17"),
    (", for {age}", "1 d"),
    (", last seen {age} ago", "1 d"),
    (", by an old report: it is unreachable now", ""),
    (", by an old report: last seen {age} ago", "1 d"),
    (", by a kept report: it has not reported itself yet", ""),
)


async def announce(house: VirtualHouse, name: str, kind: str, **more: object) -> None:
    """Announce a binary sensor of the class *kind*, which reports on ``home/NAME``."""
    config = {
        "name": None,
        "unique_id": name,
        "device_class": kind,
        "state_topic": f"home/{name}",
        "device": {"identifiers": [name], "name": name},
        **more,
    }
    await house.says(f"homeassistant/binary_sensor/{name}/config", json.dumps(config))
    await house.run_for("4s")


@pytest.fixture
def world(request: pytest.FixtureRequest) -> World:
    return load_world(HOUSES / f"{request.param}.toml", seed=3)


def told(house: VirtualHouse) -> list[str]:
    return [one.text for one in house.notifications if one.app == "alerts"]


def news(house: VirtualHouse) -> list[str]:
    """Return what was told, without ages, and once what was told again."""
    return [text for text, _ in groupby(one.partition(",")[0] for one in told(house))]


async def shown(house: VirtualHouse) -> tuple[Finding, ...]:
    """Return what the page shows."""
    async with Node(house.runtime.graph, "screen") as page:
        return (await page.create_subscription(Findings, ALERT_FINDINGS, None, qos_profile_latched).receive()).findings


@pytest.mark.rooms("homeassistant")
@pytest.mark.parametrize(
    ("kind", "begin", "end", "code"),
    [
        ("moisture", "is wet", "is dry again", "HB424"),
        ("smoke", "reports smoke or heat", "no longer reports smoke or heat", "HB421"),
        ("gas", "reports gas", "no longer reports gas", "HB423"),
        ("carbon_monoxide", "reports carbon monoxide", "no longer reports carbon monoxide", "HB422"),
    ],
)
@pytest.mark.house(config=NOTIFY)
async def test_a_danger_is_told_within_two_seconds_and_once_and_so_is_its_end(
    house: VirtualHouse, kind: str, begin: str, end: str, code: str
) -> None:
    await announce(house, "Sink", kind)
    await house.says("home/Sink", "OFF")
    await house.run_for("1m")
    assert told(house) == []
    assert await shown(house) == ()
    await house.says("home/Sink", "ON")
    await house.run_for("2s")
    assert told(house) == [f"Alert: Sink {begin}"]
    assert json.loads(await house.hears("homebot/notifications"))["message"] == f"Sink {begin}"
    (finding,) = await shown(house)
    assert (finding.code, finding.is_problem, finding.rows[0].why) == (code, True, begin)
    assert finding.urgency == "danger"
    await house.run_for("50m")
    assert (await shown(house))[0].rows[0].why == f"{begin}, for 49 min"
    await house.says("home/Sink", "OFF")
    await house.run_for("2s")
    assert await shown(house) == ()
    assert [one.partition(",")[0] for one in told(house)] == [f"Alert: Sink {begin}"] * 4  # and after 5, 15, 35 min
    await house.run_for("6m")
    assert told(house)[4:] == [f"Over: Sink {end}"]


@pytest.mark.rooms("homeassistant")
@pytest.mark.parametrize(
    ("kind", "wait", "text"),
    [
        ("tamper", 60, "reports tampering"),
        *((kind, 300, "reports a problem") for kind in ("problem", "safety", "heat")),
    ],
)
@pytest.mark.house(config=NOTIFY)
async def test_what_is_less_urgent_is_shown_at_once_and_told_later(
    house: VirtualHouse, kind: str, wait: float, text: str
) -> None:
    await announce(house, "Hall", kind)
    await house.says("home/Hall", "ON")
    await house.run_for(wait - 5)
    assert [one.rows[0].why.split(",")[0] for one in await shown(house)] == [text]
    assert told(house) == []
    await house.run_for("10s")
    assert len(told(house)) == 1


FIRE_DETECTOR = {
    "ieee_address": "0x00158d0001abcdef",
    "friendly_name": "Loft",
    "interview_completed": True,
    "definition": {
        "model": "HESZB-120",
        "exposes": [
            {"type": "binary", "name": "heat", "property": "heat", "access": 1, "value_on": True, "value_off": False}
        ],
    },
}


@pytest.mark.rooms("homie")
@pytest.mark.house(config=NOTIFY)
async def test_a_homie_device_in_alert_has_a_problem(house: VirtualHouse) -> None:
    for attribute, text in (
        ("$homie", "4.0.0"),
        ("$name", "Well"),
        ("$nodes", "pump"),
        ("pump/$name", "Pump"),
        ("pump/$properties", "on"),
        ("pump/on/$datatype", "boolean"),
        ("$state", "alert"),
    ):
        await house.says(f"homie/well/{attribute}", text)
    await house.run_for("4s")
    assert [one.code for one in await shown(house)] == ["HB427"]
    await house.says("homie/well/$state", "ready")
    await house.run_for("2s")
    assert await shown(house) == ()


@pytest.mark.rooms("zigbee2mqtt")
@pytest.mark.house(config=NOTIFY)
async def test_the_heat_of_a_fire_detector_is_a_fire(house: VirtualHouse) -> None:
    await house.says("zigbee2mqtt/bridge/devices", json.dumps([FIRE_DETECTOR]))
    await house.run_for("4s")
    await house.says("zigbee2mqtt/Loft", json.dumps({"heat": True}))
    await house.run_for("2s")
    assert told(house) == ["Alert: Loft reports smoke or heat"]


@pytest.mark.rooms("homeassistant")
@pytest.mark.parametrize(
    ("name", "kind", "is_door"),
    [
        ("Hall", "door", True),
        ("Hall", "garage_door", True),
        ("Front door", "opening", True),
        ("Haustür", "opening", True),
        ("Bath", "opening", False),
        ("Bath", "window", False),
    ],
)
@pytest.mark.house(config=NOTIFY)
async def test_a_door_is_told_after_a_quarter_of_an_hour_and_a_window_never(
    house: VirtualHouse, name: str, kind: str, *, is_door: bool
) -> None:
    await announce(house, name, kind)
    await house.says(f"home/{name}", "ON")
    await house.run_for("14m")
    assert (await shown(house), told(house)) == ((), [])
    await house.run_for("70s")
    assert len(await shown(house)) == is_door
    assert told(house) == ([f"Alert: {name} is open, for 15 min"] if is_door else [])


@pytest.mark.rooms("homeassistant", "owntracks", "people")
@pytest.mark.house(config=NOTIFY | {"people": {"Ben": {"trackers": ["ben phone"]}}})
@pytest.mark.parametrize(("regions", "is_told"), [([], True), (["Home"], False), (None, False)])
async def test_an_open_door_is_told_after_a_minute_while_nobody_is_home(
    house: VirtualHouse, regions: list[str] | None, *, is_told: bool
) -> None:
    """Unknown is not away."""
    await announce(house, "Hall", "door")
    await house.says("owntracks/ben/phone", json.dumps({"_type": "location", "inregions": regions, "tst": 1}))
    await house.says("home/Hall", "ON")
    await house.run_for("3m")
    assert told(house) == (["Alert: Hall is open, for 1 min"] if is_told else [])


@pytest.mark.rooms("homeassistant")
@pytest.mark.house(config=NOTIFY | {"alerts": {"leak": "10m", "smoke": False, "door": "1h"}})
async def test_the_delay_of_each_kind_can_be_set(house: VirtualHouse) -> None:
    for name, kind in (("Sink", "moisture"), ("Roof", "smoke"), ("Hall", "door")):
        await announce(house, name, kind)
        await house.says(f"home/{name}", "ON")
    await house.run_for("5m")
    assert told(house) == []
    await house.run_for("10m")
    assert told(house)[0] == "Alert: Sink is wet, for 10 min"
    await house.run_for("1h")
    assert set(news(house)) == {"Alert: Sink is wet", "Alert: Hall is open"}
    assert {one.code for one in await shown(house)} == {"HB401", "HB421", "HB424", "HB428"}


def test_an_unknown_kind_is_an_error() -> None:
    with pytest.raises(ConfigError, match=r"alerts\.leek"):
        make_plan(parse_config({"alerts": {"leek": 5}}, "homebot.toml"))


@pytest.mark.rooms("homeassistant")
@pytest.mark.house(config=NOTIFY)
async def test_a_sensor_that_flaps_is_told_twice_an_hour_at_most(house: VirtualHouse) -> None:
    await announce(house, "Sink", "moisture")
    for number in range(720):  # for twelve hours, half a minute wet and half a minute dry, or ten and ten minutes
        await house.says("home/Sink", "ON" if number % 2 else "OFF")
        await house.run_for("30s" if number < 240 else "75s")
    assert news(house) == ["Alert: Sink is wet"]
    for _ in range(12):
        await house.says("home/Sink", "OFF")
        await house.run_for("10m")
        await house.says("home/Sink", "ON")
        await house.run_for("10m")
    assert news(house) == ["Alert: Sink is wet", "Over: Sink is dry again", "Alert: Sink is wet"]
    assert len(told(house)) < 2 * 16


@pytest.mark.rooms("homeassistant")
@pytest.mark.house(config=NOTIFY)
async def test_silence_does_not_end_an_alert(house: VirtualHouse) -> None:
    await announce(house, "Sink", "moisture", availability_topic="home/Sink/status", value_template="{{ value }}")
    await house.says("home/Sink/status", "online")
    await house.says("home/Sink", "ON")
    await house.run_for("5s")
    assert news(house) == ["Alert: Sink is wet"]
    await house.says("home/Sink", "None")
    await house.run_for("1h")
    assert news(house) == ["Alert: Sink is wet"]
    await house.says("home/Sink/status", "offline")
    await house.run_for("1h")
    assert news(house) == ["Alert: Sink is wet"]
    await house.says("home/Sink/status", "online")
    await house.says("home/Sink", "OFF")
    await house.run_for("6m")
    assert news(house)[1:] == ["Over: Sink is dry again"]


@pytest.mark.rooms("homeassistant")
@pytest.mark.house(config=NOTIFY)
async def test_the_old_word_of_an_unreachable_sensor_is_told_as_such(house: VirtualHouse) -> None:
    await announce(house, "Sink", "moisture", availability_topic="home/Sink/status")
    await house.says("home/Sink/status", "offline")
    await house.run_for("1m")
    async with house.client("old") as old:
        await old.wait_connected()
        await old.publish("home/Sink", b"ON", qos=1, retain=True)
    await house.run_for("1m")
    (text,) = told(house)
    assert text == "Alert: Sink is wet, by an old report: it is unreachable now"


@pytest.mark.rooms("homeassistant")
@pytest.mark.house(config=NOTIFY)
async def test_each_part_of_a_panel_is_told(house: VirtualHouse) -> None:
    for zone in ("Kitchen", "Cellar"):
        config = {
            "name": zone,
            "unique_id": zone,
            "device_class": "moisture",
            "state_topic": f"panel/{zone}",
            "device": {"identifiers": ["panel"], "name": "Panel"},
        }
        await house.says(f"homeassistant/binary_sensor/panel/{zone}/config", json.dumps(config))
    await house.run_for("5s")
    await house.says("panel/Kitchen", "ON")
    await house.run_for("1m")
    await house.says("panel/Cellar", "ON")
    await house.run_for("1m")
    assert told(house) == ["Alert: Panel is wet", "Alert: Panel Cellar is wet"]


async def announce_battery(house: VirtualHouse, name: str) -> dict[str, object]:
    """Announce a sensor of a battery; return its device."""
    device: dict[str, object] = {"identifiers": [name], "name": name}
    config = {"name": None, "unique_id": f"{name} battery", "device": device, "state_topic": f"{name}/battery"}
    config |= {"device_class": "battery", "unit_of_measurement": "%"}
    await house.says(f"homeassistant/sensor/{name}_battery/config", json.dumps(config))
    return device


@pytest.mark.rooms("homeassistant")
@pytest.mark.house(config=NOTIFY)
async def test_weak_batteries_are_told_together_once_a_day_but_not_that_of_a_vacuum_cleaner(
    house: VirtualHouse,
) -> None:
    """At ten, of those that have been weak for a day."""
    for name in ("Sink", "Roof"):
        await announce_battery(house, name)
    device = await announce_battery(house, "Robby")
    vacuum = {"name": None, "unique_id": "Robby", "device": device, "command_topic": "Robby/set"}
    await house.says("homeassistant/vacuum/Robby/config", json.dumps(vacuum))
    await house.run_for("5s")
    for hour in range(60):
        for name in ("Sink", "Robby", *(["Roof"] if hour > 5 else [])):
            await house.says(f"{name}/battery", str(19 - hour // 10))
        await house.run_for("1h")
    assert told(house) == ["Alert: Roof has a weak battery (16 %)\nSink has a weak battery (16 %)"]
    assert house.notifications[0].urgency == "low"
    assert house.notifications[0].time.hour == 10


@pytest.mark.rooms("homeassistant")
@pytest.mark.house(config=NOTIFY)
async def test_a_battery_that_wavers_is_weak_until_it_has_thirty_percent(house: VirtualHouse) -> None:
    await announce_battery(house, "Sink")
    await house.run_for("5s")
    for hour in range(24 * size(3, nightly=15)):
        await house.says("Sink/battery", str((19, 22, 18, 26)[hour % 4]))
        await house.run_for("1h")
    assert [one.partition(" (")[0] for one in told(house)] == ["Alert: Sink has a weak battery"]
    await house.says("Sink/battery", "30")
    await house.run_for("1d")
    assert told(house)[1:] == ["Over: Sink has a good battery again"]


@pytest.mark.rooms("homeassistant")
@pytest.mark.house(config={"notify": {}, "home": {"language": "de"}})
async def test_a_fire_is_told_alone_first_and_again_until_it_is_seen(house: VirtualHouse) -> None:
    await announce(house, "Flur", "smoke")
    await announce(house, "0x00158d0001a2b3c4", "smoke", device={"identifiers": ["x"], "name": "0x00158d0001a2b3c4"})
    await announce(house, "Haustür", "door")
    for name in ("Flur", "0x00158d0001a2b3c4", "Haustür"):
        await house.says(f"home/{name}", "ON")
    await house.run_for("16m")
    said = [(one.text.partition(",")[0], one.urgency, one.kind) for one in house.notifications]
    smoke = [
        ("Alarm: a smoke co alarm meldet Rauch oder Hitze", "high", "smoke"),
        ("Alarm: Flur meldet Rauch oder Hitze", "high", "smoke"),
    ]
    assert said == [*smoke, *smoke, ("Alarm: Haustür ist offen", "normal", "door"), *smoke]
    repeats: list[bool] = []
    async with Node(house.runtime.graph, "screen") as page:
        page.create_subscription(Findings, ALERT_FINDINGS, lambda one: repeats.append(one.repeats), qos_profile_latched)
        await house.run_for("1s")
        assert repeats.pop()
        await page.create_client(Trigger, SEE_ALERTS.name).call(TriggerRequest())
        await house.run_for("3h")
    assert repeats
    assert not any(repeats), "the page has a button as long as it is of use"
    assert len(house.notifications) == len(said)
    await house.says("home/Flur", "OFF")
    await house.run_for("10m")
    assert [one.text for one in house.notifications][len(said) :] == [
        "Vorbei: Flur meldet keinen Rauch und keine Hitze mehr"
    ]


@pytest.mark.rooms("homeassistant")
@pytest.mark.house(config=NOTIFY | {"alerts": {"unreachable": "1m"}})
async def test_people_read_of_no_id_of_what_cannot_be_reached(house: VirtualHouse) -> None:
    await announce(house, "Sink", "moisture", availability_topic="home/Sink/status")
    await house.says("home/Sink/status", "offline")
    await house.run_for("2m")
    await house.says("home/Sink/status", "online")
    await house.says("home/Sink", "OFF")
    await house.run_for("6m")
    assert told(house) == ["Alert: Sink is unreachable", "Over: Sink is reachable again"]


@pytest.mark.rooms("homeassistant")
@pytest.mark.house(config=NOTIFY)
async def test_a_door_whose_state_is_unknown_for_moments_is_told_in_time_unless_it_was_closed(
    house: VirtualHouse,
) -> None:
    """Every restart of Home Assistant passes through unknown: each began the quarter of an hour anew."""
    await announce(house, "Haustür", "door")
    await house.says("home/Haustür", "ON")
    for between, count in (["None"], 1), (["None", "OFF"], 0):
        before = len(told(house))
        for _ in range(4):
            await house.run_for("5m")
            for state in (*between, "ON"):
                await house.says("home/Haustür", state)
                await house.run_for("10s")
        assert len(told(house)) == before + count
        await house.says("home/Haustür", "OFF")
        await house.run_for("2h")
        await house.says("home/Haustür", "ON")


@pytest.mark.house
@pytest.mark.parametrize("later", ["0s", "10m"])
async def test_a_gateway_that_is_away_is_shown_at_once_and_told_after_two_minutes(
    house: VirtualHouse, later: str
) -> None:
    """Also one that is there later than the alerts."""
    await house.run_for(later)
    async with Node(house.runtime.graph, "hub", namespace="/gateway") as node:
        states = node.create_publisher(GatewayState, GatewayNames("hub").state, qos_profile_latched)
        states.publish(GatewayState(state="active", reason="", acts=True))
        await house.run_for("10s")
        states.publish(GatewayState(state="unavailable", reason="the connection was refused", acts=True))
        await house.run_for("100s")
        (finding,) = await shown(house)
        text = "gateway hub is away: the connection was refused"
        assert (finding.code, finding.rows[0].why, told(house)) == ("HB302", text, [])
        await house.run_for("1m")
        assert told(house) == ["Alert: gateway hub is away"]
        states.publish(GatewayState(state="active", reason="", acts=True))
        await house.run_for("10m")
        assert told(house)[1:] == ["Over: gateway hub is back"]


@pytest.mark.rooms("homeassistant")
@pytest.mark.house(config={"notify": {}, "gateways": {"mqtt": {"act": False}}})
async def test_a_message_that_was_not_sent_is_repeated_less_and_less_often(house: VirtualHouse) -> None:
    await announce(house, "Sink", "moisture")
    await house.says("home/Sink", "ON")
    await house.run_for("10m")
    assert 4 <= len(told(house)) <= 6


@asynccontextmanager
async def homebot(folder: Path, broker: MemoryBroker, clock: LoopClock) -> AsyncIterator[Runtime]:
    """Run a homebot that remembers."""
    config = parse_config({"gateways": {"mqtt": {}}}, "test")
    services, index = [HostedBroker.in_memory(broker)], folder / "index.sqlite"
    async with Runtime(config, with_door=False, clock=clock, services=services, index_file=index) as runtime:
        await anyio.sleep(10)
        yield runtime


@pytest.mark.rooms("homeassistant")
async def test_a_restart_tells_nothing_again_and_what_ended_meanwhile(tmp_path: Path) -> None:
    clock, random = LoopClock(), Random(0)  # noqa: S311 - a test has no secrets
    async with MemoryBroker(clock=clock, random=random) as broker:
        options = MqttOptions(host=broker.host, port=broker.port, client_id="field")
        async with MqttConnection(options, broker.make_client, status_topic=None, clock=clock, random=random) as field:
            await field.wait_connected()
            await field.publish("homeassistant/binary_sensor/sink/config", SINK.encode(), qos=1, retain=True)
            async with homebot(tmp_path, broker, clock) as runtime:
                await field.publish("home/sink", b"ON", qos=1)
                await anyio.sleep(70)
                assert [one.text for one in runtime.app_host.notifier.recent] == [
                    "Alert: Sink reports tampering, for 1 min"
                ]
            async with homebot(tmp_path, broker, clock) as runtime:  # not a word of the sensor
                await anyio.sleep(600)
                assert [*runtime.app_host.notifier.recent] == []
                await field.publish("home/sink", b"ON", qos=1)
                await anyio.sleep(600)
                assert [*runtime.app_host.notifier.recent] == []
            await field.publish("home/sink", b"OFF", qos=1, retain=True)
            async with homebot(tmp_path, broker, clock) as runtime:
                await anyio.sleep(600)
                assert [one.text for one in runtime.app_host.notifier.recent] == [
                    "Over: Sink no longer reports tampering"
                ]


@WHOLE_HOUSE
@pytest.mark.parametrize(
    ("world", "days"), [("family", size(7, nightly=21)), ("mixed", size(1, nightly=7))], indirect=["world"]
)
async def test_a_family_is_told_for_weeks_of_what_is_wrong_and_of_nothing_else(world: World, days: int) -> None:
    """Its front lock jams now and then; a leak each night is told at once; a sensor that is away for a day is not."""
    async with virtual_house_of(world=world, config=NOTIFY) as house:
        midnight, started = house.clock.now(), house.world.event_log.count
        await announce(house, "Sink", "moisture", availability_topic="home/Sink/status")
        for day in range(days):
            await house.says("home/Sink/status", "online")
            await house.says("home/Sink", "OFF")
            await house.run_for("1h")
            await house.says("home/Sink", "ON")
            await house.run_for("2s")
            assert told(house)[-1] == "Alert: Sink is wet"
            await house.says("home/Sink", "OFF")
            await house.run_for("2h")
            await house.says("home/Sink/status", "offline")
            await house.run_for(midnight + (day + 1) * DAY - house.clock.now())
        jams = jams_of(world.event_log.since(started))
        news = [(one.text, one.time.timestamp() - midnight) for one in house.notifications]
        assert [text for text, _ in news if "Sink" in text] == [
            "Alert: Sink is wet",
            "Over: Sink is dry again",
        ] * days
        others = [one for one in news if "Sink" not in one[0]]
        begun = [at for text, at in others if text == "Alert: front_lock reports a problem, for 5 min"]
        ended = [at for text, at in others if text == "Over: front_lock no longer reports a problem"]
        assert len(begun) + len(ended) == len(others)
        assert all(any(begin + 300 <= at <= min(end, begin + 303) for begin, end in jams) for at in begun)
        assert all(any(0 < at - end <= 3603 for _, end in jams) for at in ended)
        first = [
            jam for before, jam in pairwise([(0.0, -DAY), *jams]) if jam[1] - jam[0] > 303 and jam[0] > before[1] + DAY
        ]
        assert all(any(begin < at <= end for at in begun) for begin, end in first)
        assert world.event_log.dropped == 0


def jams_of(happened: Iterable[Event]) -> list[tuple[float, float]]:
    """Return when the front lock began and ceased to say that it is jammed, in seconds since the first midnight."""
    said = [one for one in happened if (one.who, one.verb) == ("front_lock", "says")]
    runs = [[*run] for _, run in groupby(said, lambda one: one.what == "jammed")]
    return [
        (run[0].at, after[0].at)
        for run, after in pairwise([*runs, [said[-1]._replace(at=math.inf)]])
        if run[0].what == "jammed"
    ]


def incident(key: str, since: float = 100.0) -> Alert:
    return Alert(ALERTS[0], key, key, since)


def test_of_more_alerts_than_a_hundred_the_first_are_told() -> None:
    alerts = {str(number): incident(str(number)) for number in range(MAX_INCIDENTS + 5)}
    found = update_incidents({}, alerts, (), 200.0)
    assert list(found) == [str(number) for number in range(MAX_INCIDENTS)]
    for number in range(5):
        alerts = {f"{number} {place}": incident("") for place in range(MAX_INCIDENTS)}
        told = {key: one._replace(is_told=True) for key, one in found.items()}
        found = update_incidents(told, alerts, told.keys(), 300.0)
    assert len(found) == 2 * MAX_INCIDENTS


def test_the_time_of_an_alert_that_nobody_knows_is_now() -> None:
    """Nor is one of the future late."""
    found = update_incidents({}, {"a": incident("a", 0.0), "b": incident("b", 1e9)}, (), 200.0)
    assert {one.since for one in found.values()} == {200.0}


@pytest.mark.parametrize("kind", [*ALERTS, GATEWAY], ids=lambda one: one.key)
def test_each_kind_is_said_in_all_languages(kind: AlertKind) -> None:
    for alert in (Alert(kind, "id", "Sink", 0.0, (text,)) for text in DETAILS):
        texts = [text for language in LANGUAGES for text in (alert.told(language), alert.over(language))]
        assert all(text.count(alert.target if kind is GATEWAY else "Sink") == 1 and "{" not in text for text in texts)
        assert all("1 d" in text for text in texts[::2]) is ("{age}" in alert.said[0][0])


def test_the_page_shows_what_can_wait_as_such() -> None:
    urgencies = {kind.key: kind.shown_urgency for kind in (*ALERTS, GATEWAY)}
    assert {key for key, urgency in urgencies.items() if urgency == "danger"} == {"smoke", "co", "gas", "leak", "alarm"}
    assert {kind.finding.code for kind in ALERTS if kind.shown_urgency == "later"} == {"HB401", "HB402", "HB404"}


def test_the_page_has_the_findings_and_the_next_steps_of_urgent_ones_in_all_languages() -> None:
    findings = [kind.finding for kind in ALERTS]
    words = {kind.finding.next_step for kind in ALERTS if kind.shown_urgency != "later"}
    assert words | {finding.title for finding in findings} <= TABLE.keys()


def test_the_directory_reports_changes_of_all_that_alerts_are_about() -> None:
    assert WATCHED - SETTABLE == ALERTING
    assert CAPABILITIES.keys() >= WATCHED
    assert {one.key for one in (*ALERTS, GATEWAY)} == set(get_args(AlertKey))


@pytest.mark.house(config=NOTIFY)
async def test_what_a_program_asks_is_sent_once_with_the_way_to_answer(house: VirtualHouse) -> None:
    question = OpenQuestion(
        question="1-2",
        text="the client agent wants: door → unlocked",
        device="door",
        issuer="client:agent",
        until=NEVER,
    )
    async with Node(house.runtime.graph, "asking") as node:
        asked = node.create_publisher(OpenQuestions, OPEN_QUESTIONS, qos_profile_latched)
        await house.run_for("10s")
        for _ in range(2):
            asked.publish(OpenQuestions(questions=(question,)))
            await house.run_for("1s")
    assert [one.text for one in house.notifications] == [
        "Question: the client agent wants: door → unlocked? Answer: homebot answer 1-2 yes (or no), or on the page, "
        "within a minute"
    ]


@pytest.mark.house(config=NOTIFY)
async def test_a_question_does_not_wait_for_the_notification_of_another(house: VirtualHouse) -> None:
    """It lives a minute; here who takes the notifications has room for one."""
    questions = tuple(
        OpenQuestion(question=name, text=name, device="door", issuer="client:agent", until=NEVER)
        for name in ("one", "two", "three")
    )
    async with Node(house.runtime.graph, "asking") as node:
        asked = node.create_publisher(OpenQuestions, OPEN_QUESTIONS, qos_profile_latched)
        node.create_subscription(RawCommand, GatewayNames("mqtt").out, None, 1)
        await house.run_for("10s")
        asked.publish(OpenQuestions(questions=questions))
        await house.run_for("1s")
        assert [one.text.partition("?")[0] for one in house.notifications] == [
            "Question: one",
            "Question: two",
            "Question: three",
        ]
