"""Clients of the door that take more than their share, for real over sockets: the others have theirs."""

import json
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from tests.patience import PATIENCE
from tests.sizes import size
from tests.system.attack_probe import Attacked, attacked, until
from tests.system.broker_probe import Client as Mqtt
from tests.system.test_attacks_door import MOST_BUSY, call, guest
from tests.turns import slowness
from websockets.sync.client import ClientConnection

from homebot.mqtt.packets import Connect, MqttSubscription, ProtocolVersion, Publish, Subscribe

pytestmark = [pytest.mark.system, pytest.mark.no_cover, pytest.mark.rooms("homeassistant")]

LAMP = {"name": "Hall lamp", "unique_id": "hall", "command_topic": "hall/set", "state_topic": "hall/state"}
HOUSE = """
[gateways.mqtt]
[door.tokens.honest]
token_file = "honest.token"
scope = ["read", "act: light"]
"""


def obey(opened: socket.socket) -> None:
    """Be the lamp until *opened* is closed."""
    lamp = Mqtt(opened, Connect("hall", ProtocolVersion.V5))
    config = json.dumps(LAMP).encode()
    lamp.send(Subscribe(1, (MqttSubscription("hall/set", 0),)))
    lamp.send(Publish("homeassistant/light/hall/config", config, 0, retain=True), Publish("hall/state", b"OFF"))
    try:
        while True:
            if isinstance(told := lamp.take(), Publish):
                lamp.send(Publish("hall/state", told.payload))
    except (OSError, AssertionError):  # the end of the test
        return


@contextmanager
def house(folder: Path) -> Iterator[tuple[Attacked, dict[str, Any], ClientConnection]]:
    """A homebot with a lamp that obeys, and a client with a token that may command it."""
    (folder / "homebot.toml").write_text(HOUSE)
    (folder / "honest.token").touch(mode=0o600)
    (folder / "honest.token").write_text("honest-secret")
    with attacked(folder, "--config", "homebot.toml") as homebot:
        opened = socket.create_connection(("127.0.0.1", homebot.broker), timeout=PATIENCE)
        lamp = threading.Thread(target=obey, args=(opened,))
        lamp.start()
        try:
            with guest(homebot, "honest-secret") as honest:
                (device,) = until(lambda: devices(honest) or None, PATIENCE)
                assert hold(honest, device["id"], 0)[0]  # what the first command loads is not the cost of an attack
                homebot.toll()
                yield homebot, device, honest
        finally:
            opened.shutdown(socket.SHUT_RDWR)
            lamp.join()
            opened.close()


def devices(peer: ClientConnection) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = call(peer, "/discovery/find_devices")["values"]["devices"]
    return found


def hold(peer: ClientConnection, device: str, name: int) -> tuple[bool, str]:
    """Hold the lamp on for an hour; return whether it is held, and what came of it."""
    setting = {"capability": "on_off", "value": {"type": 1, "flag": True}}
    lease = {"lease": f"{name}", "by": "r", "issuer": "", "ttl": 3600.0}
    values = call(peer, "/control/hold", device=device, setting=setting, **lease)["values"]
    return values["held"], values["result"]["text"]


def holders(peer: ClientConnection) -> list[str]:
    return [one["issuer"] for part in call(peer, "/control/leases")["values"]["parts"] for one in part["holders"]]


def test_one_client_takes_fifty_leases_at_most_and_none_stays_when_it_left(tmp_path: Path) -> None:
    with house(tmp_path) as (homebot, device, honest):
        with guest(homebot) as greedy:
            answers = [hold(greedy, device["id"], number) for number in range(60)]
            assert [held for held, _ in answers] == [True] * 50 + [False] * 10
            assert "client:local has 50 leases already" in answers[-1][1]
            toll = homebot.toll()
            print(f"\n60 leases of one client: {toll}")
            assert toll.busy < MOST_BUSY * slowness()
            assert hold(honest, device["id"], 1)[0]
        until(lambda: True if holders(honest) == ["client:honest"] * 2 else None, PATIENCE)


def test_a_flood_of_equal_commands_takes_little_of_the_journal(tmp_path: Path) -> None:
    with house(tmp_path) as (homebot, device, _), guest(homebot) as greedy:
        setting = {"capability": "on_off", "value": {"type": 1, "flag": True}}
        count = size(300, 1000)
        for _ in range(count):
            assert call(greedy, "/control/perform", device=device["id"], settings=[setting], issuer="")["result"]
        toll = homebot.toll()
        entries = call(greedy, "/control/journal")["values"]["entries"]
        own = [one for one in entries if one["issuer"] == "client:local"]
        print(f"\n{count} equal commands of one client: {len(own)} entries, {toll}")
        assert toll.busy < MOST_BUSY * slowness()
        assert len(own) < 100
        assert max(one["folded"] for one in own) > count / 2
        assert {"held"} <= {one["kind"] for one in entries if one["issuer"] == "client:honest"}
