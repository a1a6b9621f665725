"""Robots that hold a door through a real WebSocket and are killed: it is not closed on them, nor stays blocked."""

import itertools
import json
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from tests.patience import PATIENCE
from tests.system.attack_probe import Attacked, attacked
from tests.system.broker_probe import Client as Mqtt
from tests.system.test_attacks_door import call, guest, owner_of, send
from websockets.sync.client import ClientConnection

from homebot.mqtt.packets import Connect, MqttSubscription, ProtocolVersion, Publish, Subscribe

pytestmark = [pytest.mark.system, pytest.mark.no_cover, pytest.mark.rooms("homeassistant")]

ROBOT = Path(__file__).with_name("holding_robot.py")
TTL = 5.0
DOOR = {
    "name": "Hall door",
    "unique_id": "hall",
    "device_class": "door",
    "command_topic": "hall/set",
    "state_topic": "hall/state",
}
CLOSE = {"target": "Hall door", "command": "close"}
HOUSE = """
[gateways.mqtt]
[door.tokens.robot]
token_file = "robot.token"
scope = ["read", "act: closure"]
"""


class MqttDoor:
    """The door, by the broker: it does what it hears.

    Attributes:
        heard: The commands, oldest first.
    """

    def __init__(self, opened: socket.socket) -> None:
        self.heard: list[str] = []
        self._mqtt = Mqtt(opened, Connect("hall", ProtocolVersion.V5))
        self._mqtt.send(Subscribe(1, (MqttSubscription("hall/set", 0),)))
        config = json.dumps(DOOR).encode()
        self._mqtt.send(Publish("homeassistant/cover/hall/config", config, 0, retain=True))
        self.report("closed")

    def report(self, state: str) -> None:
        self._mqtt.send(Publish("hall/state", state.encode()))

    def obey(self) -> None:
        """Do the next command."""
        while not isinstance(heard := self._mqtt.take(), Publish):
            pass
        self.heard.append(heard.payload.decode())
        self.report({"OPEN": "open", "CLOSE": "closed"}[self.heard[-1]])


@contextmanager
def robot(homebot: Attacked, device: dict[str, Any], name: str) -> Iterator[subprocess.Popen[str]]:
    part = next(one["id"] for one in device["parts"] if one["part"]["service_type"] == "closure")
    command = [sys.executable, str(ROBOT), homebot.url, "robot-secret", device["id"], part, name, str(TTL)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def says(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().strip()


def close(peer: ClientConnection) -> dict[str, Any]:
    """Close the door as a person does; return the result."""
    answer = call(peer, "/devices/command", **CLOSE)["values"]
    result: dict[str, Any] = answer["results"][0]["result"]
    return result


def kinds(peer: ClientConnection) -> list[tuple[str, str]]:
    entries = call(peer, "/control/journal")["values"]["entries"]
    steps = {"held", "released", "ended", "expired", "outranked", "handed_back"}
    return [(one["kind"], one["text"]) for one in entries if one["kind"] in steps]


def holders(peer: ClientConnection) -> list[str]:
    parts = call(peer, "/control/leases")["values"]["parts"]
    return [one["by"] for part in parts for one in part["holders"]]


def wait_until_gone(owner: ClientConnection, name: str, others: Callable[[], object]) -> None:
    """Wait until a robot holds nothing, while *others* do something now and then."""
    for number in itertools.count():
        if name not in holders(owner):
            return
        if number % 20 == 0:
            others()


@contextmanager
def house(folder: Path) -> Iterator[tuple[Attacked, dict[str, Any], MqttDoor, ClientConnection, ClientConnection]]:
    """A homebot and its approved door, by the broker too, with the owner and somebody else at a client."""
    (folder / "homebot.toml").write_text(HOUSE)
    (folder / "robot.token").touch(mode=0o600)
    (folder / "robot.token").write_text("robot-secret")
    with attacked(folder, "--config", "homebot.toml") as homebot:
        opened = socket.create_connection(("127.0.0.1", homebot.broker), timeout=PATIENCE)
        with opened, guest(homebot, owner_of(folder)) as owner, guest(homebot, "robot-secret") as person:
            door = MqttDoor(opened)
            while not (known := call(owner, "/discovery/find_devices")["values"]["devices"]):
                pass
            assert call(owner, "/discovery/approve", device=known[0]["id"])["values"]["success"]
            yield homebot, known[0], door, owner, person


def test_a_door_is_never_closed_on_a_robot_and_free_when_the_last_was_killed(tmp_path: Path) -> None:
    with house(tmp_path) as (homebot, device, door, owner, person):
        with robot(homebot, device, "first") as first, robot(homebot, device, "second") as second:
            door.obey()
            assert {says(first), says(second)} == {"held"}
            refused = close(person)
            assert (refused["outcome"], refused["policy"]) == ("refused", "lease")
            assert "first" in refused["reason"]
            first.kill()
            refusals: list[dict[str, Any]] = []
            wait_until_gone(owner, "first", lambda: refusals.append(close(person)))
            refusals.append(close(person))
            assert {one["policy"] for one in refusals} == {"lease"}
            assert "second" in refusals[-1]["reason"]
            assert door.heard == ["OPEN"]
            second.kill()
            wait_until_gone(owner, "second", lambda: None)
        send(person, op="call_service", id="close", service="/devices/command", timeout=PATIENCE, args=CLOSE)
        door.obey()
        assert json.loads(person.recv(timeout=PATIENCE))["values"]["outcome"] == "confirmed"
        assert door.heard == ["OPEN", "CLOSE"]
        told = kinds(owner)
        assert sorted(told) == sorted((kind, name) for kind in ("held", "released") for name in ("first", "second"))
        assert told.index(("released", "first")) < told.index(("released", "second"))


def test_a_person_ends_the_lease_of_a_robot_that_lives(tmp_path: Path) -> None:
    with house(tmp_path) as (homebot, device, door, owner, person):
        with robot(homebot, device, "first") as first:
            door.obey()
            assert says(first) == "held"
            assert call(person, "/control/end_leases", device=device["id"])["result"] is False
            assert close(person)["policy"] == "lease"
            (part,) = call(owner, "/control/end_leases", device=device["id"])["values"]["parts"]
            assert [one["issuer"] for one in part["holders"]] == ["client:robot"]
            assert first.wait(PATIENCE) == 0
        assert kinds(owner) == [("held", "first"), ("ended", "first")]
        assert call(owner, "/control/leases")["values"]["parts"] == []
