"""Mosquitto's command line clients against the embedded broker."""

import shutil
import subprocess
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from anyio.abc import Process
from tests.mqtt.client.mosquitto_broker import MOSQUITTO, until_it_answers
from tests.patience import PATIENCE
from tests.ports import reserve_port

from homebot.mqtt.broker import Broker

VERSIONS = ["mqttv31", "mqttv311", "mqttv5"]

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(shutil.which("mosquitto_rr") is None, reason="mosquitto-clients is not installed"),
]


@pytest.fixture
async def broker() -> AsyncIterator[Broker]:
    async with Broker() as broker:
        await publish(broker, "-t", "mark", "-m", "ready", "-r")
        yield broker


async def publish(broker: Broker, *arguments: str, version: str = "mqttv5") -> None:
    """Run mosquitto_pub to its end."""
    command = ["mosquitto_pub", "-p", str(broker.port), "-V", version, *arguments]
    with anyio.fail_after(PATIENCE):
        await anyio.run_process(command)


@asynccontextmanager
async def listener(broker: Broker, *arguments: str, version: str = "mqttv5") -> AsyncIterator[Process]:
    """A mosquitto_sub that has subscribed: the retained mark has come."""
    command = ["mosquitto_sub", "-p", str(broker.port), "-V", version, "-t", "mark", *arguments]
    process = await anyio.open_process([*command, "-F", "%t %q %r %p"], stderr=subprocess.DEVNULL)
    async with process:
        try:
            assert (await lines(process, 1))[0] == "mark 0 1 ready"
            yield process
        finally:
            if process.returncode is None:
                process.kill()


async def lines(process: Process, count: int) -> list[str]:
    """The next *count* lines of its output."""
    assert process.stdout is not None
    text = b""
    with anyio.fail_after(PATIENCE):
        while text.count(b"\n") < count:
            text += await process.stdout.receive()
    return text.decode().splitlines()


@pytest.mark.parametrize("version", VERSIONS)
async def test_messages_arrive_at_every_qos_in_every_version(broker: Broker, version: str) -> None:
    async with listener(broker, "-t", "home/#", "-q", "2", version=version) as subscriber:
        for qos in ("0", "1", "2"):
            await publish(broker, "-t", "home/lamp", "-q", qos, "-m", f"qos {qos}", version=version)
        assert await lines(subscriber, 3) == [f"home/lamp {qos} 0 qos {qos}" for qos in range(3)]


@pytest.mark.parametrize("version", VERSIONS)
async def test_many_messages_at_qos_2_all_arrive_once(broker: Broker, version: str) -> None:
    async with listener(broker, "-t", "n", "-q", "2", version=version) as subscriber:
        numbers = "\n".join(str(number) for number in range(300))
        command = ["mosquitto_pub", "-p", str(broker.port), "-V", version, "-t", "n", "-q", "2", "-l"]
        with anyio.fail_after(PATIENCE):
            await anyio.run_process(command, input=numbers.encode())
        assert await lines(subscriber, 300) == [f"n 2 0 {number}" for number in range(300)]


async def test_a_retained_message_meets_a_later_subscriber_and_can_be_removed(broker: Broker) -> None:
    publisher = ["mosquitto_pub", "-p", str(broker.port), "-t", "kept", "-r", "-q", "1", "-s"]
    await anyio.run_process(publisher, input=b"x" * 900_000)
    command = ["mosquitto_sub", "-p", str(broker.port), "-V", "mqttv311", "-t", "kept", "-C", "1", "-W", "10"]
    result = await anyio.run_process(command)
    assert len(result.stdout) == 900_001
    await publish(broker, "-t", "kept", "-n", "-r", version="mqttv311")
    assert broker.stats.retained_bytes == len(b"markready")


@pytest.mark.parametrize("version", VERSIONS)
async def test_the_will_of_a_killed_client_is_published(broker: Broker, version: str) -> None:
    async with listener(broker, "-t", "will/#", version="mqttv5") as watcher:
        last_words = ["--will-topic", "will/x", "--will-payload", "gone", "--will-qos", "1"]
        async with listener(broker, *last_words, version=version) as victim:
            victim.kill()
            await victim.wait()
        assert await lines(watcher, 1) == ["will/x 0 0 gone"]


async def test_a_session_is_kept_while_its_client_is_away(broker: Broker) -> None:
    stay = ["-c", "-i", "stayer", "-t", "queue", "-q", "1"]
    async with listener(broker, *stay, version="mqttv311"):
        pass
    await publish(broker, "-t", "queue", "-q", "1", "-m", "while away")
    command = ["mosquitto_sub", "-p", str(broker.port), "-V", "mqttv311", *stay, "-C", "1", "-R", "-W", "10"]
    result = await anyio.run_process(command)
    assert result.stdout == b"while away\n"


@asynccontextmanager
async def bridge(broker: Broker, folder: Path, version: str) -> AsyncIterator[int]:
    """A Mosquitto that bridges ``home/#`` both ways, with nothing else configured; gives its port."""
    port = reserve_port()
    (folder / "mosquitto.conf").write_text(
        f"listener {port} 127.0.0.1\nuser root\nallow_anonymous true\nconnection homebot\n"
        f"address 127.0.0.1:{broker.port}\nbridge_protocol_version {version}\ntopic home/# both 1\n"
    )
    command = [str(MOSQUITTO), "-c", str(folder / "mosquitto.conf")]
    async with await anyio.open_process(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        try:
            await until_it_answers(port)
            yield port
        finally:
            process.kill()


@pytest.mark.skipif(MOSQUITTO is None, reason="mosquitto is not installed")
@pytest.mark.parametrize("version", ["mqttv31", "mqttv311", "mqttv50"])
async def test_a_mosquitto_that_bridges_both_ways_gets_and_gives_each_message_once(
    broker: Broker, tmp_path: Path, version: str
) -> None:
    async with bridge(broker, tmp_path, version) as port, listener(broker, "-t", "home/#") as here:
        await publish(broker, "-t", "home/mark", "-m", "bridged", "-r")
        assert await lines(here, 1) == ["home/mark 0 0 bridged"]
        command = ["mosquitto_sub", "-p", str(port), "-t", "home/#", "-F", "%t %p"]
        async with await anyio.open_process(command) as there:
            assert await lines(there, 1) == ["home/mark bridged"]
            await publish(broker, "-t", "home/a", "-m", "1", "-q", "1", "-r")
            assert await lines(there, 1) == ["home/a 1"]
            assert await lines(here, 1) == ["home/a 0 0 1"]
            for topic, payload in (("home/b", "2"), ("home/c", "3")):
                await anyio.run_process(["mosquitto_pub", "-p", str(port), "-t", topic, "-m", payload, "-q", "1"])
                assert await lines(there, 1) == [f"{topic} {payload}"]
                assert await lines(here, 1) == [f"{topic} 0 0 {payload}"]
            there.kill()
        kept = ["mosquitto_sub", "-p", str(port), "-t", "home/a", "-C", "1", "-W", "10", "-F", "%r %p"]
        assert (await anyio.run_process(kept)).stdout == b"1 1\n"


async def test_a_request_gets_its_response(broker: Broker) -> None:
    async with listener(broker, "-t", "ask") as responder:
        command = ["mosquitto_rr", "-p", str(broker.port), "-V", "mqttv5", "-t", "ask", "-e", "answer"]
        async with await anyio.open_process([*command, "-m", "ping?", "-W", "10"]) as requester:
            assert await lines(responder, 1) == ["ask 0 0 ping?"]
            await publish(broker, "-t", "answer", "-m", "pong!")
            assert await lines(requester, 1) == ["pong!"]


async def test_mqtt_5_properties_go_through(broker: Broker) -> None:
    command = ["mosquitto_sub", "-p", str(broker.port), "-V", "mqttv5", "-t", "p", "-C", "1", "-W", "10"]
    properties = ["content-type text", "user-property k v", "response-topic r"]
    arguments = [part for each in properties for part in ("-D", "PUBLISH", *each.split())]
    await publish(broker, "-t", "p", "-m", "x", "-r", *arguments)
    result = await anyio.run_process([*command, "-F", "%C %P %R %p"])
    assert result.stdout.decode().split() == ["text", "k:v", "r", "x"]


async def test_user_and_password_are_asked_for() -> None:
    async with Broker(credentials={"ann": "right"}) as broker:
        await publish(broker, "-t", "t", "-m", "x", "-u", "ann", "-P", "right", version="mqttv31")
        for version in VERSIONS:
            command = ["mosquitto_pub", "-p", str(broker.port), "-V", version, "-t", "t", "-m", "x"]
            result = await anyio.run_process([*command, "-u", "ann", "-P", "wrong"], check=False)
            assert result.returncode != 0
            assert b"authori" in result.stderr.lower() or b"password" in result.stderr.lower()
