"""How long a client at the door waits at worst while others make homebot work, of 1,000 lamps.

homebot, the robot and the publisher are processes of their own. The peer is the same door while nothing happens.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from websockets.sync.client import ClientConnection, connect

import raw_mqtt
from house import lamp_topics
from mosquitto import mosquitto
from plan import Plan
from report import MissingPeerError, Report, milliseconds, verdict
from rounds import median
from worker import worker

__all__ = ["run"]

LAMPS, FLOODED = 1000, 48
MESSAGES = 100_000
CALLS = 100
WORST = 0.05
EVERY, IDLE, PATIENCE = 0.005, 2.0, 60.0
ROBOT = "rosie"
TITLE = f"waits: the slowest answers at the door of a house with {LAMPS:,} lamps"
HEADINGS = ("meanwhile", "answers", "median", "slowest", "aim")


def run(plan: Plan) -> Report:
    if plan.mosquitto is None or find_spec("zenoh") is None:
        raise MissingPeerError("Mosquitto or Zenoh is not installed")
    rows: list[tuple[str, ...]] = [HEADINGS]
    lost: list[str] = []
    with (
        mosquitto(plan.mosquitto) as broker,
        house(broker) as (door, link, folder),
        worker("load_generator.py") as publisher,
    ):
        secret = (folder / f"{ROBOT}.token").read_text().strip()
        with worker("waits_robot.py", sys.executable, link, ROBOT, secret) as robot:
            door.wait_for(LAMPS)
            _say_once(broker)
            door.wait_for(LAMPS + FLOODED)

            def flood() -> None:
                publisher.start("flood", port=broker, topics=lamp_topics(FLOODED), count=plan.count(MESSAGES), qos=0)
                publisher.result()

            def ask(count: int) -> Callable[[], object]:
                def asked() -> None:
                    robot.start("ask", count=count)
                    answers = robot.result()["devices"]
                    if short := count - sum(devices >= LAMPS for devices in answers):
                        lost.append(f"{short} of {count} queries had no whole answer.")

                return asked

            def stop() -> None:
                robot.start("ask", count=CALLS)
                time.sleep(0.1)
                os.kill(robot.greeting["pid"], signal.SIGSTOP)
                time.sleep(8.0)  # Zenoh gives it up after five
                os.kill(robot.greeting["pid"], signal.SIGCONT)
                robot.result()

            for meanwhile, work in (
                ("nothing", lambda: time.sleep(IDLE)),
                (f"floods on {FLOODED} topics of devices", flood),
                ("a query of all devices by Zenoh", ask(1)),
                (f"{CALLS} of them", ask(CALLS)),
                (f"{CALLS} of them, their robot hangs", stop),
            ):
                time.sleep(1.0)
                rows.append((meanwhile, *door.waits(work)))
    return Report(TITLE, [], lost, rows)


def _say_once(broker: int) -> None:
    """Let the devices be found that are flooded afterwards."""
    with raw_mqtt.connect(broker, "bench-first-words") as sock:
        sock.sendall(b"".join(raw_mqtt.publish_packet(topic, b"00000000") for topic in lamp_topics(FLOODED)))


class Door:
    """A client at the door."""

    def __init__(self, client: ClientConnection) -> None:
        self._client = client

    def wait_for(self, devices: int) -> None:
        """Wait until that many are known."""
        deadline = time.monotonic() + PATIENCE
        while self._call("/discovery/query", limit=1)["total"] < devices:
            if time.monotonic() > deadline:
                raise TimeoutError(f"{devices} devices were not found")
            time.sleep(0.2)

    def waits(self, work: Callable[[], object]) -> tuple[str, ...]:
        """Ask for the time, again and again, during *work*; return the rest of a row."""
        took: list[float] = []
        thread = threading.Thread(target=work)
        thread.start()
        while thread.is_alive():
            began = time.perf_counter()
            self._call("/rosapi/get_time")
            took.append(time.perf_counter() - began)
            time.sleep(EVERY)
        worst = max(took)
        aim = f"<= {milliseconds(WORST)}: {verdict(worst <= WORST)}"
        return f"{len(took):,}", milliseconds(median(took)), milliseconds(worst), aim

    def _call(self, service: str, **values: object) -> dict[str, int]:
        self._client.send(json.dumps({"op": "call_service", "id": "w", "service": service, "args": values}))
        while (answer := json.loads(self._client.recv(timeout=PATIENCE))).get("id") != "w":
            pass
        found: dict[str, int] = answer["values"]
        return found


@contextmanager
def house(broker: int) -> Iterator[tuple[Door, str, Path]]:
    """Run homebot; yield a client at its door, the address of its link, and its folder."""
    door, link = _free_port(), f"tcp/127.0.0.1:{_free_port()}"
    with TemporaryDirectory() as name:
        folder = Path(name)
        token = folder / f"{ROBOT}.token"
        token.touch(0o600)
        token.write_text("a secret of the robot\n")
        (folder / "homebot.toml").write_text(f"""
[home]
name = "bench"
[gateways.mqtt]
url = "mqtt://127.0.0.1:{broker}"
[gateways.lamps]
class = "machines_gateway:Lamps"
devices = {LAMPS}
max_devices = {LAMPS}
[door]
port = {door}
[door.tokens.{ROBOT}]
token_file = "{token.name}"
scope = ["read", "robot: {ROBOT}"]
[ros]
listen = "{link}"
export = ["/discovery/query"]
import = {{{ROBOT} = ["/{ROBOT}/**"]}}
""")
        command = [sys.executable, "-m", "homebot", "run", "--ephemeral", "--log-format", "json"]
        environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parent), "HOMEBOT_DATA": name}
        with (folder / "log").open("wb") as log:
            process = subprocess.Popen(command, cwd=folder, env=environment, stdout=log, stderr=log)
        try:
            _wait_for(door)
            with connect(f"ws://127.0.0.1:{door}", proxy=None, compression=None) as client:
                yield Door(client), link, folder
        finally:
            process.terminate()
            process.wait()


def _wait_for(port: int) -> None:
    deadline = time.monotonic() + PATIENCE
    while True:
        try:
            socket.create_connection(("127.0.0.1", port)).close()
        except ConnectionRefusedError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.2)
        else:
            return


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
