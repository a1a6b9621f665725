"""A large Home Assistant: processor time of the gateway for 5,000 entities, and for each change of one.

A server in a thread of its own speaks Home Assistant's WebSocket; the time is that of the thread that homebot runs in.
The peer is a bare client of websockets, which parses the same frames as JSON.
"""

from __future__ import annotations

import asyncio
import json
import tempfile
import threading
import time
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from websockets.asyncio.client import connect
from websockets.asyncio.server import ServerConnection, serve

from homebot.devices import GatewayState
from homebot.graph import Graph, Node
from homebot.integrations.homeassistant.gateway import HomeAssistantGateway, HomeAssistantGatewaySettings
from plan import Plan
from report import Aim, Report, compare
from rounds import measure_interleaved

__all__ = ["run"]

ENTITIES = 5_000
CHANGES = 4_000
RATE = 200
OURS, BARE = "gateway", "bare websockets client"
TITLE = "A large Home Assistant: processor time"


def run(plan: Plan) -> Report:
    entities, changes = plan.count(ENTITIES), plan.count(CHANGES)
    comparisons, share = [], 0.0
    with served(entities, changes) as (port, go):
        for case, index in ((f"{entities} entities", 0), ("each change", 1)):
            samples = measure_interleaved(
                {
                    OURS: partial(figure, index, lambda: homebot_gateway(port, go, entities, changes)),
                    BARE: partial(figure, index, lambda: bare_client(port, go, changes)),
                },
                plan.rounds(3),
            )
            comparisons += compare(case, samples, [(OURS, BARE, None)], lambda one: f"{one * 1000:.3g} ms")
            share = max(samples[OURS]) * RATE
    verdict = Aim("at most", 0.2).verdict(share)
    return Report(TITLE, comparisons, (f"At {RATE} changes a second: {share:.1%} of a processor, {verdict}.",))


def figure(index: int, measure: Callable[[], Coroutine[None, None, tuple[float, float]]]) -> float:
    return asyncio.run(measure())[index]


@contextmanager
def served(entities: int, changes: int) -> Iterator[tuple[int, Callable[[], object]]]:
    """Serve a Home Assistant in a thread; return its port, and the function that lets it send the changes."""
    frames = Frames(entities, changes)
    started, port = threading.Event(), [0]
    loop = asyncio.new_event_loop()
    stop = asyncio.Event()

    async def main() -> None:
        async with serve(frames.talk, "127.0.0.1", 0, max_size=None, compression=None) as server:
            port[0] = next(iter(server.sockets)).getsockname()[1]
            started.set()
            await stop.wait()

    thread = threading.Thread(target=loop.run_until_complete, args=(main(),))
    thread.start()
    started.wait()
    try:
        yield port[0], partial(loop.call_soon_threadsafe, frames.go.set)
    finally:
        loop.call_soon_threadsafe(stop.set)
        thread.join()


class Frames:
    """The frames of a Home Assistant with lamps and sensors."""

    def __init__(self, entities: int, changes: int) -> None:
        names = [f"{'light' if number % 2 else 'sensor'}.e{number}" for number in range(entities)]
        lamp = {"supported_color_modes": ["brightness"], "brightness": 100, "color_mode": "brightness"}
        meter = {"device_class": "power", "unit_of_measurement": "W", "state_class": "measurement"}
        states = {
            one: {"s": "on", "a": lamp, "c": "1", "lc": 1.0}
            if one.startswith("light")
            else {"s": "1.0", "a": meter, "c": "1", "lc": 1.0}
            for one in names
        }
        self.answers: dict[str, object] = {
            "get_config": {"unit_system": {"temperature": "°C"}},
            "config/device_registry/list": [
                {"id": f"d{number}", "name": f"device {number}", "identifiers": [["demo", f"d{number}"]]}
                for number in range(entities // 2)
            ],
            "config/entity_registry/list": [
                {"entity_id": one, "id": one, "unique_id": one, "device_id": f"d{number // 2}", "original_name": one}
                for number, one in enumerate(names)
            ],
        }
        self.go = asyncio.Event()
        self.states = {"a": states}
        self.changes = [
            {"c": {name: {"+": {"s": f"{number}.5", "lc": 2.0}}}}
            for number, name in ((number, names[2 * number % entities]) for number in range(changes))
        ]

    async def talk(self, peer: ServerConnection) -> None:
        await peer.send('{"type":"auth_required","ha_version":"2024.3.3"}')
        await peer.recv()
        await peer.send('{"type":"auth_ok","ha_version":"2024.3.3"}')
        async for text in peer:
            asked = json.loads(text)
            if asked["type"] == "subscribe_entities":
                await self._send_states(peer, asked["id"])
            else:
                result = self.answers.get(asked["type"], [])
                await peer.send(json.dumps({"id": asked["id"], "type": "result", "success": True, "result": result}))

    async def _send_states(self, peer: ServerConnection, number: int) -> None:
        await peer.send(json.dumps({"id": number, "type": "result", "success": True, "result": None}))
        await peer.send(json.dumps({"id": number, "type": "event", "event": self.states}))
        await self.go.wait()
        self.go.clear()
        for change in self.changes:
            await peer.send(json.dumps({"id": number, "type": "event", "event": change}))
        await peer.close()


async def homebot_gateway(port: int, go: Callable[[], object], entities: int, changes: int) -> tuple[float, float]:
    """Return the processor time until all devices are there, and that of each change."""
    graph = Graph()
    with tempfile.TemporaryDirectory() as folder:
        token = Path(folder) / "token"
        token.touch(mode=0o600)
        token.write_text("token")
        settings = HomeAssistantGatewaySettings(url=f"http://127.0.0.1:{port}", token_file=token)
        async with Node(graph, "homeassistant", namespace="/gateway") as node, Node(graph, "watcher") as watcher:
            states = watcher.create_subscription(GatewayState, "/gateway/homeassistant/state")
            gateway = HomeAssistantGateway(node, settings)
            began = time.thread_time()
            serving = asyncio.ensure_future(gateway.serve())
            while (await states.receive()).state != "active":
                pass
            ready = time.thread_time()
            assert len(gateway.devices.keys) == entities // 2
            go()
            while (await states.receive()).state == "active":
                pass
            ended = time.thread_time()
            serving.cancel()
            await asyncio.gather(serving, return_exceptions=True)
    return ready - began, (ended - ready) / changes


async def bare_client(port: int, go: Callable[[], object], changes: int) -> tuple[float, float]:
    """Do the same by a client that only parses."""
    began = time.thread_time()
    async with connect(f"ws://127.0.0.1:{port}/api/websocket", max_size=None, compression=None, proxy=None) as peer:
        await peer.send("{}")
        kinds = ("get_config", "config/device_registry/list", "config/entity_registry/list", "subscribe_entities")
        for number, kind in enumerate(kinds):
            await peer.send(json.dumps({"id": number, "type": kind}))
        for _ in range(len(kinds) + 3):
            json.loads(await peer.recv())
        ready = time.thread_time()
        go()
        async for text in peer:
            json.loads(text)
    return ready - began, (time.thread_time() - ready) / changes
