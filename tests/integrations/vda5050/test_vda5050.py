"""Robots of VDA 5050, by its schemas, in both directions."""

import json
from collections.abc import Mapping
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError
from tests.integrations.vda5050.robot import FleetRobot

from homebot.clock import home_time
from homebot.conventions.convention import Convention
from homebot.conventions.description import DeviceAnnounced, DeviceRequest, Publication, Publications
from homebot.conventions.robot_pose import StatedPose
from homebot.conventions.unreadable import FOUND
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.integrations.vda5050.formats import Vda5050, Vda5050Settings
from homebot.integrations.vda5050.formats.pose import Vda5050Poses
from homebot.places.rigid import MapPose

NODES = {"dock": [0.0, 0.0], "Hall": [2.0, 1.0, 1.57], "lift": []}
VERSIONS = pytest.mark.parametrize("major", [2, 3])


def convention(**table: object) -> Vda5050:
    return Vda5050(Vda5050Settings.model_validate_json(json.dumps({"nodes": NODES} | table)))


def told(found: Convention, said: Publication) -> DeviceAnnounced:
    device, *_ = found.read_message(said.topic, said.payload, retained=said.retain)
    assert isinstance(device, DeviceAnnounced)
    return device


class Fleet:
    """A robot, and the device that homebot makes of it."""

    def __init__(self, robot: FleetRobot, **table: object) -> None:
        self.robot = robot
        self.device = told(convention(**table), robot.connection())

    def read(self, state: Mapping[str, Any] | None = None) -> dict[str, PlainValue]:
        """Let the robot tell its state; return what each part reads, by part and capability."""
        payload = json.dumps(self.robot.told() if state is None else state).encode()
        return {
            f"{part.part.id}.{name}": value
            for part in self.device.parts
            for name, value in part.codec.read(f"{self.robot.base}/state", payload, retained=False).items()
        }

    def command(self, value: PlainValue, part: str = "") -> Publications:
        """Command a part, and let the robot take what is published, on the topics that the part lists."""
        (described,) = [one for one in self.device.parts if one.part.id == part]
        sent = described.codec.write("option", value)
        for one in sent:
            assert one.topic in described.part.writes
            self.robot.take(one.topic, one.payload)
        return sent


@VERSIONS
def test_a_robot_is_one_device_by_its_maker_and_serial_number(major: int) -> None:
    robot = FleetRobot(major)
    found = convention()
    assert [said.topic.rpartition("/")[2] for said in (robot.connection(), robot.state())] == ["connection", "state"]
    first, again = told(found, robot.connection()), told(found, robot.state())
    assert first is again
    assert (first.key, first.name, first.owns) == ("KIT/0001", "KIT 0001", (robot.base,))
    assert [part.part.id for part in first.parts] == ["", "destination", "errors", "x", "y"]
    assert "model" not in first.facts
    assert told(found, robot.factsheet()).facts["model"] == "Transporter 7"


@VERSIONS
def test_its_last_will_says_that_it_cannot_be_reached(major: int) -> None:
    robot = FleetRobot(major)
    availability = told(convention(), robot.connection()).availability
    assert availability is not None
    (source,) = availability.sources
    assert source.topic == f"{robot.base}/connection"
    assert source.read(robot.last_will.payload) is False
    assert [source.read(payload) for payload in (b"", b"{", b"[]", b'{"connectionState": []}')] == [None] * 4


MEANINGS: dict[str, dict[str, object]] = {
    "connectionState": {
        "ONLINE": True,
        **dict.fromkeys(("OFFLINE", "CONNECTIONBROKEN", "CONNECTION_BROKEN", "HIBERNATING"), False),
    },
    "operatingMode": {
        **dict.fromkeys(("AUTOMATIC", "SEMIAUTOMATIC"), "idle"),
        **dict.fromkeys(("MANUAL", "SERVICE", "TEACHIN", "TEACH_IN", "STARTUP", "INTERVENED"), "manual"),
    },
    "actionStatus": {
        **dict.fromkeys(("WAITING", "INITIALIZING", "RUNNING", "PAUSED", "RETRIABLE"), "working"),
        **dict.fromkeys(("FINISHED", "FAILED"), "idle"),
    },
    "errorLevel": {"WARNING": "idle", "URGENT": "idle", "CRITICAL": "error", "FATAL": "error"},
    "eStop": {"NONE": "idle", **dict.fromkeys(("AUTOACK", "MANUAL", "REMOTE"), "error")},
}
"""What homebot makes of each word in an enumeration."""

_SECOND = {
    "connectionState": "ONLINE OFFLINE CONNECTIONBROKEN",
    "operatingMode": "AUTOMATIC SEMIAUTOMATIC MANUAL SERVICE TEACHIN",
    "actionStatus": "WAITING INITIALIZING RUNNING FINISHED FAILED",
    "errorLevel": "WARNING FATAL",
    "eStop": "AUTOACK MANUAL REMOTE NONE",
}
SCHEMAS = {
    "2.0.0": _SECOND,
    "2.1.0": _SECOND | {"actionStatus": "WAITING INITIALIZING RUNNING PAUSED FINISHED FAILED"},
    "3.0.0": {
        "connectionState": "ONLINE OFFLINE HIBERNATING CONNECTION_BROKEN",
        "operatingMode": "STARTUP AUTOMATIC SEMIAUTOMATIC INTERVENED MANUAL SERVICE TEACH_IN",
        "actionStatus": "WAITING INITIALIZING RUNNING RETRIABLE PAUSED FINISHED FAILED",
        "errorLevel": "WARNING URGENT CRITICAL FATAL",
        "eStop": "MANUAL REMOTE NONE",
    },
}
"""The enumerations of ``connection.schema`` and ``state.schema``, github.com/VDA5050/VDA5050; 3.0 has another key for
``eStop``."""


@pytest.mark.parametrize(
    ("version", "name", "word"),
    [(version, name, word) for version, names in SCHEMAS.items() for name in names for word in names[name].split()],
)
def test_each_word_that_a_schema_allows_has_its_meaning(version: str, name: str, word: str) -> None:
    robot, meaning = FleetRobot(int(version[0])), MEANINGS[name][word]
    match name:
        case "connectionState":
            availability = told(convention(), robot.connection()).availability
            assert availability is not None
            assert availability.sources[0].read(robot.connection(word).payload) is meaning
            return
        case "operatingMode":
            robot.mode = word
        case "actionStatus":
            robot.actions = [{"actionId": "lift", "actionStatus": word}]
        case "errorLevel":
            robot.errors = [{"errorType": "lost", "errorLevel": word}]
        case "eStop":
            robot.stop = word
    assert Fleet(robot).read()[".option"] == meaning


@VERSIONS
def test_a_robot_says_why_it_refuses_an_order_or_an_action(major: int) -> None:
    fleet = Fleet(FleetRobot(major, closed=("Hall",)))
    refusal = fleet.device.parts[0].refusal
    assert refusal is not None
    fleet.read()
    order = fleet.command("Hall", "destination")
    assert refusal(order) == ""
    fleet.read()
    assert refusal(order) == "orderError (warning): no way to Hall"
    pause = fleet.command("paused")
    fleet.robot.actions[-1] |= {"actionType": "startPause", "actionStatus": "FAILED", "resultDescription": "not now"}
    fleet.read()
    assert refusal(pause) == "startPause failed: not now"
    assert refusal(fleet.command("Hall", "destination")) == ""


def test_an_error_of_an_order_that_the_robot_drives_is_no_refusal() -> None:
    fleet = Fleet(FleetRobot())
    fleet.read()
    order = fleet.command("Hall", "destination")
    about = [{"referenceKey": "orderId", "referenceValue": json.loads(order[0].payload)["orderId"]}]
    fleet.robot.errors = [{"errorType": "slow", "errorLevel": "WARNING", "errorReferences": about}]
    fleet.read()
    refusal = fleet.device.parts[0].refusal
    assert refusal is not None
    assert refusal(order) == ""


@VERSIONS
def test_a_state_that_was_overtaken_is_dropped_and_counted_and_one_after_a_restart_counts(major: int) -> None:
    fleet = Fleet(FleetRobot(major, x=1.0))
    late = fleet.robot.told()
    fleet.robot.x = 2.0
    fleet.read()
    FOUND.clear()
    assert fleet.read(late) == {}
    (found,) = FOUND
    assert "expects a headerId after" in found.why()
    again = {"headerId": 0, "timestamp": "2026-11-30T11:00:00.000Z"}
    assert fleet.read(fleet.robot.told() | again)["x.measurement"] == 2.0


def test_the_ids_of_actions_are_unique_over_restarts() -> None:
    robot, ids = FleetRobot(), set[str]()
    state = robot.told()
    at = datetime(2026, 11, 30, 12, tzinfo=UTC)
    for start in range(3):
        token = home_time.set(lambda start=start: at + timedelta(seconds=start))  # type: ignore[misc]
        found = convention()
        _, asked = found.read_message(robot.connection().topic, robot.connection().payload, retained=True)
        assert isinstance(asked, DeviceRequest)
        fleet = Fleet(robot)
        fleet.read(state)
        sent = *asked.publications, *fleet.command("paused"), *fleet.command("paused")
        ids |= {json.loads(one.payload)["actions"][0]["actionId"] for one in sent}
        home_time.reset(token)
    assert len(ids) == 9


@VERSIONS
def test_a_robot_that_does_not_know_where_it_is_gets_no_order_and_one_that_never_tells_gets_one(major: int) -> None:
    fleet, key = Fleet(FleetRobot(major)), "agvPosition" if major == 2 else "mobileRobotPosition"
    state = fleet.robot.told()
    fleet.read(state | {key: {"x": 0, "y": 0, "mapId": "", "positionInitialized": False, "localized": False}})
    with pytest.raises(RefusedError, match="does not know where it is"):
        fleet.command("Hall", "destination")
    del state[key]
    fleet.read(state)
    (order,) = fleet.command("Hall", "destination")
    assert ["nodePosition" in node for node in json.loads(order.payload)["nodes"]] == [False, False]


@VERSIONS
def test_a_state_tells_where_a_robot_is_and_whether_it_is_free(major: int) -> None:
    fleet = Fleet(FleetRobot(major, x=1.234, y=-2.0))
    assert fleet.read() == {
        ".option": "idle",
        ".place": "dock",
        ".moving": False,
        ".problem": False,
        ".safety": False,
        ".battery": 80.0,
        ".battery_charging": False,
        "destination.option": "dock",
        "errors.value": "none",
        "x.measurement": 1.23,
        "y.measurement": -2.0,
    }


@VERSIONS
@pytest.mark.parametrize(
    ("change", "activity"),
    [
        ({}, "idle"),
        ({"charging": True}, "charging"),
        ({"paused": True, "charging": True}, "paused"),
        ({"mode": "SEMIAUTOMATIC"}, "idle"),
        ({"mode": "MANUAL", "paused": True}, "manual"),
        ({"stop": "MANUAL", "mode": "MANUAL"}, "error"),
        ({"ahead": [{"nodeId": "Hall", "sequenceId": 2, "released": True, "actions": []}]}, "working"),
        ({"actions": [{"actionId": "lift", "actionStatus": "RUNNING"}]}, "working"),
        ({"errors": [{"errorType": "lost", "errorLevel": "WARNING"}]}, "idle"),
        ({"errors": [{"errorType": "lost", "errorLevel": "FATAL"}]}, "error"),
    ],
)
def test_the_gravest_that_a_robot_tells_is_what_it_does(major: int, change: dict[str, Any], activity: str) -> None:
    assert Fleet(FleetRobot(major, **change)).read()[".option"] == activity


def test_errors_are_told_in_words() -> None:
    errors = [
        {"errorType": "blocked", "errorLevel": "WARNING", "errorDescription": "a box\nin the way"},
        *({"errorType": f"e{number}", "errorLevel": "FATAL"} for number in range(6)),
        "no error",
    ]
    read = Fleet(FleetRobot(errors=errors)).read()  # type: ignore[arg-type]
    assert read[".problem"] is True
    assert read["errors.value"] == (
        "blocked (warning): a box in the way; e0 (fatal); e1 (fatal); e2 (fatal); e3 (fatal); 2 more"
    )


def test_a_robot_that_does_not_know_where_it_is_has_no_position() -> None:
    fleet = Fleet(FleetRobot())
    state = fleet.robot.told()
    state["agvPosition"]["positionInitialized"] = False
    assert fleet.read(state)["x.measurement"] is None
    for wrong in ({"x": "far"}, {"x": 1e9}, {"y": None}):
        state = fleet.robot.told()
        state["agvPosition"] |= wrong
        assert fleet.read(state)["y.measurement"] is None


@VERSIONS
def test_a_destination_is_an_order_from_where_the_robot_stands(major: int) -> None:
    fleet = Fleet(FleetRobot(major))
    fleet.read()
    (sent,) = fleet.command("Hall", "destination")
    order = json.loads(sent.payload)
    assert sent == Publication(f"uagv/v{major}/KIT/0001/order", sent.payload)
    assert {key: order[key] for key in ("headerId", "version", "manufacturer", "serialNumber", "orderUpdateId")} == {
        "headerId": 0,
        "version": f"{major}.0.0",
        "manufacturer": "KIT",
        "serialNumber": "0001",
        "orderUpdateId": 0,
    }
    steps = sorted((*order["nodes"], *order["edges"]), key=lambda step: step["sequenceId"])
    assert [(step["sequenceId"], step.get("nodeId", step.get("edgeId")), step["released"]) for step in steps] == [
        (0, "dock", True),
        (1, "dock-Hall", True),
        (2, "Hall", True),
    ]
    assert order["nodes"][1]["nodePosition"] == {"x": 2.0, "y": 1.0, "mapId": "ground", "theta": 1.57}
    wide = order["nodes"][0]["nodePosition"]["allowedDeviationXY"]
    assert wide == (0.5 if major == 2 else {"a": 0.5, "b": 0.5, "theta": 0.0})
    assert ("startNodeId" in order["edges"][0]) is (major == 2)


@VERSIONS
def test_a_robot_goes_and_its_states_confirm_it(major: int) -> None:
    fleet = Fleet(FleetRobot(major))
    fleet.read()
    fleet.command("Hall", "destination")
    read = fleet.read()
    assert (read[".option"], read["destination.option"], read[".place"], read[".moving"]) == (
        "working",
        "Hall",
        None,
        True,
    )
    fleet.robot.drive()
    read = fleet.read()
    assert (read[".option"], read["destination.option"], read[".place"]) == ("idle", "Hall", "Hall")
    assert (read["x.measurement"], fleet.robot.refused) == (2.0, [])


@VERSIONS
def test_a_robot_pauses_goes_on_and_gives_up_its_order(major: int) -> None:
    fleet = Fleet(FleetRobot(major))
    fleet.read()
    fleet.command("lift", "destination")
    for activity in ("paused", "working", "idle"):
        fleet.read()
        (sent,) = fleet.command(activity)
        assert sent.topic == f"{fleet.robot.base}/instantActions"
        assert fleet.read()[".option"] == activity
    assert fleet.read()["destination.option"] == "dock"


@VERSIONS
def test_a_robot_charges_where_it_stands_or_at_the_charger(major: int) -> None:
    here, away = Fleet(FleetRobot(major)), Fleet(FleetRobot(major, node="Hall"), charger="dock")
    for fleet in (here, away):
        fleet.read()
        fleet.command("charging")
        fleet.robot.drive()
        read = fleet.read()
        assert (read[".option"], read[".place"], read[".battery_charging"]) == ("charging", "dock", True)
        fleet.command("idle")
        assert fleet.read()[".option"] == "idle"


@pytest.mark.parametrize(
    ("robot", "value", "part", "reason"),
    [
        (FleetRobot(), "attic", "destination", "it takes dock, Hall, lift"),
        (FleetRobot(), 7, "destination", "it takes dock, Hall, lift"),
        (FleetRobot(), "manual", "", "it takes idle, working, paused, charging"),
        (FleetRobot(), "working", "", "it has no order to go on with; set its destination"),
        (FleetRobot(mode="MANUAL"), "Hall", "destination", "the robot takes no orders in its mode MANUAL"),
        (
            FleetRobot(ahead=[{"nodeId": "lift", "sequenceId": 2, "released": True, "actions": []}]),
            "Hall",
            "destination",
            "the robot has an order; set its option to idle first",
        ),
    ],
)
def test_what_a_robot_cannot_do_now_is_refused(robot: FleetRobot, value: PlainValue, part: str, reason: str) -> None:
    fleet = Fleet(robot)
    fleet.read()
    with pytest.raises(RefusedError) as refused:
        fleet.command(value, part)
    assert refused.value.reason == reason


@pytest.mark.parametrize(("value", "part"), [("Hall", "destination"), ("paused", ""), ("charging", "")])
def test_no_command_is_sent_before_the_first_state(value: str, part: str) -> None:
    with pytest.raises(RefusedError, match="has not told its state yet"):
        Fleet(FleetRobot()).command(value, part)


@VERSIONS
def test_a_robot_stops_charging_before_it_takes_an_order(major: int) -> None:
    """Control sends a command again until the robot reports it."""
    fleet = Fleet(FleetRobot(major, charging=True))
    for kind in ("instantActions", "order"):
        fleet.read()
        (sent,) = fleet.command("Hall", "destination")
        assert sent.topic == f"{fleet.robot.base}/{kind}"
    assert (fleet.read()["destination.option"], fleet.robot.refused) == ("Hall", [])


@VERSIONS
def test_a_robot_of_the_house_states_its_pose_by_its_state(major: int) -> None:
    poses, robot = Vda5050Poses(), FleetRobot(major, x=3.0, y=4.0)
    assert poses.read(robot.state().payload) == StatedPose(MapPose(3.0, 4.0), 35.0)
    late = json.dumps(robot.told() | {"driving": True}).encode()
    lost = robot.told()
    lost["agvPosition" if major == 2 else "mobileRobotPosition"] |= {"positionInitialized": False, "localized": False}
    assert poses.read(json.dumps(lost).encode()) == StatedPose(None, 35.0)
    assert poses.read(late) == StatedPose(None, 35.0)
    assert poses.read(json.dumps(lost | {"driving": True}).encode()) == StatedPose(None)
    assert [poses.read(other) for other in (b'{"x": 1, "y": 2}', b"[]", b"{", b"")] == [None] * 4


@pytest.mark.parametrize(
    ("version", "lists"), [("2.0.0", {"actions", "instantActions"}), ("2.1.0", {"actions"}), ("3.0.0", {"actions"})]
)
def test_instant_actions_have_the_name_that_their_version_has(version: str, lists: set[str]) -> None:
    fleet = Fleet(FleetRobot(int(version[0])))
    fleet.read(fleet.robot.told() | {"version": version})
    (sent,) = fleet.command("paused")
    message = json.loads(sent.payload)
    assert {key for key, value in message.items() if isinstance(value, list)} == lists
    assert [message[name][0]["actionType"] for name in lists] == ["startPause"] * len(lists)


def test_an_order_that_is_sent_again_is_the_same_one() -> None:
    fleet = Fleet(FleetRobot())
    fleet.read()
    first, second = (json.loads(fleet.command("Hall", "destination")[0].payload) for _ in "ab")
    assert (first["orderId"], first["headerId"] + 1) == (second["orderId"], second["headerId"])
    assert fleet.robot.refused == []


def test_a_robot_without_nodes_has_no_destination() -> None:
    fleet = Fleet(FleetRobot(), nodes={})
    assert [part.part.id for part in fleet.device.parts] == ["", "errors", "x", "y"]


@pytest.mark.parametrize(
    ("table", "problem"),
    [
        ({"nodes": {"Hall": [1.0]}}, r"a node is \[\] or \[x, y\] or \[x, y, theta\]"),
        ({"charger": "attic"}, "charger 'attic' is none of nodes: dock, Hall, lift"),
        ({"interfaces": ["a/+"]}, "interfaces"),
    ],
)
def test_a_wrong_table_is_refused(table: dict[str, object], problem: str) -> None:
    with pytest.raises(ValidationError, match=problem):
        convention(**table)


def test_other_fleets_have_other_topics() -> None:
    found = convention(interfaces=["plant/agvs"])
    assert found.filters()[0] == "plant/agvs/+/+/+/connection"
    assert told(found, FleetRobot(interface="plant/agvs").connection()).key == "KIT/0001"


def test_robots_below_other_first_levels_are_hinted_at() -> None:
    found = convention()
    assert found.filters()[3] == "vda5050/+/+/+/connection"
    hint = 'to find it: vda5050.interfaces = ["uagv", "vda5050", "plant/agvs"]'
    assert found.hint("plant/agvs/v3/KIT/0001/state").endswith(hint)
    for known in ("uagv/v2/KIT/0001/visualization", "plant/agvs/v3/KIT/0001/order", "plant/agvs/x/KIT/0001/state"):
        assert found.hint(known) == ""


def test_ten_thousand_robots_do_not_push_out_the_first() -> None:
    found = convention()
    for number in range(10_000):
        found.read_message(f"uagv/v2/KIT/{number}/connection", b"{}", retained=True)
    assert told(found, Publication("uagv/v2/KIT/0/connection", b"{}")).key == "KIT/0"
    assert found.read_message("uagv/v2/KIT/9999/connection", b"{}", retained=True) == ()


@pytest.mark.parametrize("topic", ["uagv/x/KIT/0001/state", "uagv/v2//0001/state", "uagv/v2/KIT//state"])
def test_foreign_topics_are_no_robots(topic: str) -> None:
    assert convention().read_message(topic, b"{}", retained=False) == ()


def test_a_list_of_any_length_is_read_in_bounds() -> None:
    state = FleetRobot().told()
    state["nodeStates"] = [{"nodeId": "n" * 200}] * 400 + [{"nodeId": "Hall"}]
    state["errors"] = [{"errorType": "e" * 200, "errorDescription": "d" * 200}] * 200
    read = Fleet(FleetRobot()).read(state)
    assert read["destination.option"] == "Hall"
    assert len(str(read["errors.value"])) < 1000


_JSON = st.recursive(
    st.none() | st.booleans() | st.floats(allow_nan=False, allow_infinity=False) | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3),
    max_leaves=6,
)


@given(st.dictionaries(st.sampled_from(sorted(FleetRobot().told())), _JSON), st.sampled_from([2, 3]), st.data())
def test_any_state_is_read_and_any_order_after_it_is_valid_or_refused(
    wrong: dict[str, object], major: int, data: st.DataObject
) -> None:
    fleet = Fleet(FleetRobot(major), charger="dock")
    read = fleet.read(fleet.robot.told() | wrong)
    assert read[".option"] in {"idle", "working", "paused", "charging", "manual", "error"}
    part, value = data.draw(st.sampled_from([("destination", "Hall"), ("", "charging"), ("", "idle"), ("", "paused")]))
    try:
        (sent,) = fleet.command(value, part)
    except RefusedError:
        return
    message = json.loads(sent.payload)
    assert message["serialNumber"] == "0001"
    assert [node["sequenceId"] for node in message.get("nodes", [{"sequenceId": 0}, {"sequenceId": 2}])] == [0, 2]


@given(st.binary(max_size=60))
def test_any_payload_is_read_or_refused(payload: bytes) -> None:
    found = convention()
    try:
        found.read_message("uagv/v2/KIT/0001/state", payload, retained=False)
    except WireError:
        assert found.rejected == 1
