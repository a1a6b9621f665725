"""Both MQTT clients against a real Mosquitto."""

from __future__ import annotations

import shutil
import signal
import subprocess
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import anyio
import pytest
from tests.mqtt.client.mosquitto_broker import until_it_answers
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.turns import Lateness

from homebot.errors import LinkError, RefusedError
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.client.aiomqtt_adapter import AiomqttClient
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.connection import LinkPhase, MqttConnection
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions, MqttProtocol

MOSQUITTO = shutil.which("mosquitto") or shutil.which("mosquitto", path="/usr/sbin")

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed"),
]


ClientKind = type[AiomqttClient] | type[NativeClient]


class Mosquitto:
    """A Mosquitto on a free port that keeps its sessions on disk."""

    def __init__(self, folder: Path) -> None:
        self.port = reserve_port()
        (folder / "passwords").write_text("anna:right\n")
        (folder / "passwords").chmod(0o600)
        subprocess.run(["mosquitto_passwd", "-U", str(folder / "passwords")], check=True)
        (folder / "acl").write_text("topic readwrite #\ntopic deny secret/#\nuser anna\ntopic readwrite open/#\n")
        self._config = folder / "mosquitto.conf"
        self._config.write_text(
            f"listener {self.port} 127.0.0.1\nuser root\nallow_anonymous false\npassword_file {folder}/passwords\n"
            f"acl_file {folder}/acl\npersistence true\npersistence_location {folder}/\nmax_queued_messages 100000\n"
        )
        self._process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        self._process = subprocess.Popen(
            [str(MOSQUITTO), "-c", str(self._config)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )

    def send_signal(self, number: int) -> None:
        assert self._process is not None
        self._process.send_signal(number)

    def stop(self) -> None:
        if self._process is not None:
            self._process.terminate()
            self._process.wait()
            self._process = None


@pytest.fixture
def mosquitto(tmp_path: Path) -> Iterator[Mosquitto]:
    broker = Mosquitto(tmp_path)
    broker.start()
    yield broker
    broker.stop()


@pytest.fixture(params=["5", "3.1.1"])
def protocol(request: pytest.FixtureRequest) -> MqttProtocol:
    version: MqttProtocol = request.param
    return version


@pytest.fixture(params=[AiomqttClient, NativeClient], ids=["aiomqtt", "native"])
def kind(request: pytest.FixtureRequest) -> ClientKind:
    client: ClientKind = request.param
    return client


@asynccontextmanager
async def connected(mosquitto: Mosquitto, protocol: MqttProtocol, kind: ClientKind) -> AsyncIterator[MqttConnection]:
    async with MqttConnection(options(mosquitto, protocol=protocol), kind, status_topic=None) as connection:
        with anyio.fail_after(PATIENCE):
            await connection.wait_connected()
        yield connection


def options(mosquitto: Mosquitto, *, password: str = "right", **settings: Any) -> MqttOptions:
    settings = {"client_id": "hub", "session_expiry": 60} | settings
    return MqttOptions.from_url(f"mqtt://anna:{password}@127.0.0.1:{mosquitto.port}", **settings)


async def receive(client: MqttClient | MqttConnection, count: int) -> list[MqttMessage]:
    messages: list[MqttMessage] = []
    with anyio.fail_after(PATIENCE):
        while len(messages) < count:
            batch = await client.receive()
            client.ack(batch)
            messages += batch
    return messages


async def test_messages_of_every_qos_go_round(mosquitto: Mosquitto, protocol: MqttProtocol, kind: ClientKind) -> None:
    async with connected(mosquitto, protocol, kind) as hub:
        await hub.subscribe(MqttSubscription("open/#", 2))
        for qos in (0, 1, 2):
            await hub.publish("open/t", bytes([qos]), qos=qos)
        messages = await receive(hub, 3)
    most = 1 if kind is AiomqttClient else 2
    assert [(message.qos, message.payload) for message in messages] == [(0, b"\0"), (1, b"\1"), (most, b"\2")]


async def test_more_messages_than_any_window_go_round(
    mosquitto: Mosquitto, protocol: MqttProtocol, kind: ClientKind
) -> None:
    async with connected(mosquitto, protocol, kind) as hub, anyio.create_task_group() as tasks:
        await hub.subscribe(MqttSubscription("open/#", 1))
        for number in range(500):
            tasks.start_soon(partial(hub.publish, "open/t", b"%d" % number, qos=1))
        messages = await receive(hub, 500)
    assert {message.payload for message in messages} == {b"%d" % number for number in range(500)}


async def test_a_refused_publish_is_an_error(mosquitto: Mosquitto, kind: ClientKind) -> None:
    async with connected(mosquitto, "5", kind) as hub:  # 3.1.1 has no way to say so
        with pytest.raises(RefusedError, match="not authorized"):
            await hub.publish("secret/door", b"open", qos=1)
        await hub.publish("open/door", b"open", qos=1)


async def test_a_wrong_password_is_a_state_and_told_nowhere(
    mosquitto: Mosquitto, protocol: MqttProtocol, capfd: pytest.CaptureFixture[str], kind: ClientKind
) -> None:
    wrong = options(mosquitto, password="wr0ng", protocol=protocol)
    async with MqttConnection(wrong, kind) as connection:
        with anyio.fail_after(PATIENCE):
            async for state in connection.states():
                if state.phase is LinkPhase.REFUSED:
                    break
    assert "not authorized" in state.reason
    assert "wr0ng" not in f"{state} {capfd.readouterr()}"


async def test_a_message_that_was_not_acknowledged_comes_again(
    mosquitto: Mosquitto, protocol: MqttProtocol, kind: ClientKind
) -> None:
    crashed, successor = (kind(options(mosquitto, protocol=protocol)) for _ in range(2))
    await until_it_answers(mosquitto.port)
    async with crashed.connected():
        await crashed.subscribe(MqttSubscription("open/t", 1))
        await crashed.publish("open/t", b"x", qos=1)
        await crashed.receive()
    async with successor.connected() as session:
        assert session.resumed
        assert [message.payload for message in await receive(successor, 1)] == [b"x"]


async def test_after_a_restart_the_hub_is_back_within_two_seconds_and_has_lost_nothing(
    mosquitto: Mosquitto, protocol: MqttProtocol, kind: ClientKind
) -> None:
    accepted: set[bytes] = set()
    got: set[bytes] = set()

    async def publish(publisher: MqttConnection) -> None:
        for payload in (b"%d" % number for number in range(600)):
            while payload not in accepted:
                await publisher.wait_connected()
                with suppress(LinkError):
                    await publisher.publish("open/t", payload, qos=1)
                    accepted.add(payload)

    async def read(hub: MqttConnection) -> None:
        while len(got) < 600:
            batch = await hub.receive()
            got.update(message.payload for message in batch)
            hub.ack(batch)

    async def restart(hub: MqttConnection) -> float:
        await anyio.to_thread.run_sync(mosquitto.stop)
        await until_not(hub, LinkPhase.CONNECTED)
        await anyio.to_thread.run_sync(mosquitto.start)
        await until_it_answers(mosquitto.port)
        began = anyio.current_time()
        await hub.wait_connected()
        return anyio.current_time() - began

    other = options(mosquitto, client_id="publisher", protocol=protocol)
    with anyio.fail_after(PATIENCE):
        async with (
            connected(mosquitto, protocol, kind) as hub,
            MqttConnection(other, kind, status_topic=None) as publisher,
            anyio.create_task_group() as tasks,
        ):
            await hub.subscribe(MqttSubscription("open/t", 1))
            tasks.start_soon(publish, publisher)
            tasks.start_soon(read, hub)
            for _ in range(2):
                assert await restart(hub) < 2
    assert got == accepted


async def until_not(connection: MqttConnection, phase: LinkPhase) -> None:
    async for state in connection.states():
        if state.phase is not phase:
            return


@pytest.mark.parametrize("protocol", ["5"])
async def test_a_broker_that_is_frozen_is_noticed_and_found_again(
    mosquitto: Mosquitto, protocol: MqttProtocol, kind: ClientKind
) -> None:
    """One and a half keep-alive intervals, and a second; the socket stays open all the time."""
    wanted = replace(options(mosquitto, protocol=protocol), keep_alive=5)
    lateness = Lateness()
    async with MqttConnection(wanted, kind, status_topic=None) as connection, anyio.create_task_group() as tasks:
        with anyio.fail_after(PATIENCE):
            await connection.wait_connected()
            tasks.start_soon(lateness.watch)
            mosquitto.send_signal(signal.SIGSTOP)
            began = anyio.current_time()
            async for state in connection.states():
                if state.phase is not LinkPhase.CONNECTED:
                    break
            took = anyio.current_time() - began
            mosquitto.send_signal(signal.SIGCONT)
            await connection.wait_connected()
        tasks.cancel_scope.cancel()
    print(f"\na frozen Mosquitto was noticed after {took:.1f} s at a keep-alive of 5 s")
    assert took - lateness.seconds <= 5 * 1.5 + 1
