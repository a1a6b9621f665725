"""Fake and changed announcements of locks, over real sockets: nothing is sent that the owner did not approve.

What each attack cost is printed (``-s``).
"""

import json
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
from tests.patience import PATIENCE
from tests.sizes import size
from tests.system.attack_probe import Attacked, attacked, until
from tests.system.broker_probe import Client
from tests.system.test_attacks_announcements import MOST_BUSY, Hostile, ask, finds
from tests.turns import slowness

from homebot.cli import main
from homebot.mqtt.packets import Connect, MqttSubscription, ProtocolVersion, Publish, Subscribe

pytestmark = [
    pytest.mark.no_cover,
    pytest.mark.system,
    pytest.mark.skipif(sys.platform != "linux", reason="reads /proc"),
    pytest.mark.rooms("homeassistant"),
]

HOUSE = """
[gateways.mqtt]

[door.tokens.keys]
token_file = "keys.token"
scope = ["read", "act: lock", "manage"]
"""
FLAPS = size(200, 1_000)

Text = pytest.CaptureFixture[str]


class Listener:
    """A client that notes all that is published below some topics."""

    def __init__(self, port: int, *topics: str) -> None:
        self.seen: list[tuple[str, bytes]] = []
        opened = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        self._client = Client(opened, Connect("listener", ProtocolVersion.V5))
        self._client.send(Subscribe(1, tuple(MqttSubscription(topic) for topic in topics)))
        self._client.take()
        opened.settimeout(None)
        self._thread = threading.Thread(target=self._listen, daemon=True)
        self._thread.start()

    def _listen(self) -> None:
        while True:
            try:
                packet = self._client.take()
            except (AssertionError, OSError):
                return
            if isinstance(packet, Publish):
                self.seen.append((packet.topic, bytes(packet.payload)))

    def close(self) -> None:
        self._client.close()


def lock(name: str, *, place: str = "door", identifier: str = "door", **more: Any) -> tuple[str, bytes]:
    """The announcement of a lock."""
    told = {
        "unique_id": f"{place}_lock",
        "device": {"identifiers": [identifier], "name": name},
        "command_topic": "door/set",
        **more,
    }
    return f"homeassistant/lock/{place}/config", json.dumps(told).encode()


@contextmanager
def house(folder: Path, *topics: str) -> Iterator[tuple[Attacked, Hostile, Listener]]:
    """A homebot with a stranger at its broker, and somebody who listens to *topics*."""
    (folder / "homebot.toml").write_text(HOUSE)
    (folder / "keys.token").touch(mode=0o600)
    (folder / "keys.token").write_text("keys-secret")
    with (
        attacked(folder, "--config", "homebot.toml") as homebot,
        closing(Hostile(homebot.broker)) as hostile,
        closing(Listener(homebot.broker, *topics)) as listener,
    ):
        yield homebot, hostile, listener


def run(homebot: Attacked, *arguments: str) -> int:
    """Run a command of the program that may command locks and manage the house."""
    token = homebot.log.with_name("keys.token")
    return main(["--door", f"127.0.0.1:{homebot.door}", "--token-file", str(token), *arguments])


def test_a_fake_lock_opens_no_garage_before_its_topic_and_payload_are_approved(tmp_path: Path, capsys: Text) -> None:
    with house(tmp_path, "garage/#") as (homebot, hostile, listener):
        hostile.publish(*lock("Fake", command_topic="garage/cmd/set", payload_lock="OPEN"))
        until(lambda: finds(homebot, "Fake") or None, PATIENCE)
        for word in ("lock", "unlock"):
            assert run(homebot, "do", "Fake", word) == 1
        out, err = capsys.readouterr()
        assert "the owner has not approved it" in out + err
        hostile.publish("garage/done", b"")
        until(lambda: listener.seen or None, PATIENCE)
        assert listener.seen == [("garage/done", b"")]
        assert run(homebot, "approve", "Fake") == 0
        assert "lock=locked: garage/cmd/set OPEN" in capsys.readouterr().out  # what it would really do
        assert run(homebot, "approve", "Fake", "--undo") == 0
        assert run(homebot, "do", "Fake", "lock") == 1
        print(f"\na fake lock: {homebot.toll()}", end="")


@pytest.mark.parametrize(
    ("swapped", "problem"),
    [
        ({"payload_unlock": "LOCK", "payload_lock": "UNLOCK"}, "the payloads of its commands changed"),
        ({"command_topic": "garage/cmd/set"}, "its commands go to garage/cmd/set instead of door/set"),
        ({"identifier": "other"}, "its identifiers are id:other instead of id:door"),
    ],
)
def test_an_approved_lock_that_is_announced_differently_is_sent_nothing(
    tmp_path: Path, capsys: Text, swapped: dict[str, str], problem: str
) -> None:
    with house(tmp_path, "door/#", "garage/#") as (homebot, hostile, listener):
        hostile.publish(*lock("Door"))
        until(lambda: finds(homebot, "Door") or None, PATIENCE)
        assert run(homebot, "approve", "Door") == 0
        run(homebot, "do", "Door", "unlock")
        until(lambda: ("door/set", b"UNLOCK") in listener.seen or None, PATIENCE)
        hostile.publish(*lock("Door", **swapped))
        until(lambda: run(homebot, "find", "unapproved") == 0 or None, PATIENCE)
        capsys.readouterr()
        listener.seen.clear()
        for word in ("lock", "unlock"):
            assert run(homebot, "do", "Door", word) == 1
        out, err = capsys.readouterr()
        assert problem in out + err
        hostile.publish("garage/done", b"")
        until(lambda: listener.seen or None, PATIENCE)
        assert listener.seen == [("garage/done", b"")]
        print(f"\n{problem}: {homebot.toll()}", end="")


def test_what_joins_an_approved_lock_is_not_driven(tmp_path: Path, capsys: Text) -> None:
    with house(tmp_path, "door/#", "garage/#") as (homebot, hostile, listener):
        hostile.publish(*lock("Door"))
        until(lambda: finds(homebot, "Door") or None, PATIENCE)
        assert run(homebot, "approve", "Door") == 0
        hostile.publish(*lock("Door", place="evil", command_topic="garage/cmd/set"))
        until(lambda: run(homebot, "find", "unapproved") == 0 or None, PATIENCE)
        run(homebot, "do", "Door", "unlock")
        assert "it was announced after the owner approved the device" in "".join(capsys.readouterr())
        hostile.publish("garage/done", b"")
        until(lambda: ("garage/done", b"") in listener.seen or None, PATIENCE)
        assert {topic for topic, _ in listener.seen} <= {"door/set", "garage/done"}


@pytest.mark.parametrize("device", [{}, {"device": {"identifiers": ["door"], "name": "Door"}}])
def test_a_lamp_on_the_topic_of_an_approved_lock_unlocks_nothing(
    tmp_path: Path, capsys: Text, device: dict[str, Any]
) -> None:
    """Told on by a program that may command all that is harmless: apart, and as a part of the lock's device."""
    told = {"command_topic": "door/set", **device}
    bolt = {"unique_id": "bolt", "name": "Door", **told}
    glow = {"unique_id": "glow", "name": "Glow", "payload_on": "UNLOCK", **told}
    with house(tmp_path, "door/#") as (homebot, hostile, listener):
        hostile.publish("homeassistant/lock/front/bolt/config", json.dumps(bolt).encode())
        until(lambda: finds(homebot, "Door") or None, PATIENCE)
        assert run(homebot, "approve", "Door") == 0
        hostile.publish("homeassistant/light/front/glow/config", json.dumps(glow).encode())
        until(lambda: run(homebot, "find", "light") == 0 or None, PATIENCE)
        assert main(["--door", f"127.0.0.1:{homebot.door}", "do", "light", "on"]) == 1
        assert "refused" in capsys.readouterr().out
        hostile.publish("door/done", b"")
        until(lambda: listener.seen or None, PATIENCE)
        assert listener.seen == [("door/done", b"")]


@pytest.mark.parametrize(
    ("service", "order"),
    [
        ("/devices/command", {"target": "Glow", "command": "on"}),
        ("/control/send_text", {"device": "glow", "payload": "on"}),
    ],
)
def test_a_lamp_whose_announcement_flaps_to_the_topic_of_a_lock_unlocks_nothing(
    tmp_path: Path, service: str, order: dict[str, str]
) -> None:
    """Commands come while the directory has compared the lamp's former topic alone."""
    topic, told = "homeassistant/light/glow/config", {"unique_id": "glow", "name": "Glow", "payload_on": "UNLOCK"}
    flips = [json.dumps({**told, "command_topic": one}).encode() for one in ("door/set", "glow/set")]
    with house(tmp_path, "door/#", "glow/#") as (homebot, hostile, listener):
        hostile.publish(*lock("Door"))
        hostile.publish(topic, flips[1])
        until(lambda: finds(homebot, "Door") or None, PATIENCE)
        until(lambda: ask(homebot, service, **order)["success"] or None, PATIENCE)
        ended = threading.Event()

        def flap() -> None:
            for _ in range(FLAPS):
                hostile.publish(topic, flips[0])
                hostile.publish(topic, flips[1])
            ended.set()

        flapping = threading.Thread(target=flap)
        flapping.start()
        while not ended.is_set():
            ask(homebot, service, **order)
        flapping.join()
        hostile.publish("door/done", b"")
        until(lambda: ("door/done", b"") in listener.seen or None, PATIENCE)
        assert {topic for topic, _ in listener.seen} == {"glow/set", "door/done"}


def test_a_lock_whose_announcement_flaps_gets_no_other_command_than_was_approved(tmp_path: Path) -> None:
    """Its payloads are swapped again and again while it is unlocked again and again."""
    with house(tmp_path, "door/set") as (homebot, hostile, listener):
        hostile.publish(*lock("Door"))
        until(lambda: finds(homebot, "Door") or None, PATIENCE)
        assert run(homebot, "approve", "Door") == 0
        run(homebot, "do", "Door", "unlock")  # the first command loads what carries commands out
        homebot.toll()
        ended = threading.Event()

        def flap() -> None:
            for _ in range(FLAPS):
                hostile.publish(*lock("Door", payload_unlock="LOCK", payload_lock="UNLOCK"))
                hostile.publish(*lock("Door"))
            ended.set()

        flapping = threading.Thread(target=flap)
        flapping.start()
        unlocks = 0
        while not ended.is_set():
            run(homebot, "do", "Door", "unlock")
            unlocks += 1
        flapping.join()
        toll = homebot.toll()
        print(f"\n{FLAPS:,} swaps, {unlocks} commands, {len(listener.seen)} sent: {toll}", end="")
        assert {payload for _, payload in listener.seen} <= {b"UNLOCK"}
        assert toll.busy < MOST_BUSY * slowness()
