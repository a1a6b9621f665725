"""Gateway end to end: publisher process -> Mosquitto -> gateway -> index -> app callback, as fast as it goes.

The clock runs from the first byte that the publisher sends to the last message that the consumer has. Publisher and
broker finish long before most consumers, so the figure is the consumer's speed.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Coroutine
from functools import partial

import aiomqtt

from background import in_background
from homebot.devices import Device, Devices, RawMessage
from house import homebot_listening, lamp_topics
from mosquitto import mosquitto
from plan import Plan
from raw_mqtt import connect, publish_packet, subscribe
from report import Aim, Comparison, MissingPeerError, Report, compare, per_second
from rounds import Measure, measure_interleaved
from worker import Worker, worker

__all__ = ["run"]

MESSAGES = 20_000
LAMPS = 10
PATIENCE = 2.0
THESIS_RATE = 2.0

OURS = "gateway to app callback"
AIOMQTT = "bare aiomqtt loop"
DRAIN = "byte drain"
THESIS = "thesis, 2 messages/s"


def run(plan: Plan) -> Report:
    if plan.mosquitto is None:
        raise MissingPeerError("Mosquitto is not installed")
    count = plan.count(MESSAGES)
    comparisons: list[Comparison] = []
    losses: dict[str, int] = {}
    with mosquitto(plan.mosquitto) as port, worker("load_generator.py") as generator:
        for qos in (0, 1):
            load = Load(generator, port, count, qos, losses)
            contenders: dict[str, Measure] = {
                OURS: partial(in_a_loop, homebot_gateway, load),
                AIOMQTT: partial(in_a_loop, aiomqtt_loop, load),
                DRAIN: partial(drain, load),
            }
            samples = measure_interleaved(contenders, plan.rounds(5))
            samples[THESIS] = [THESIS_RATE] * len(samples[OURS])
            pairs = [
                (OURS, AIOMQTT, Aim("at least", 1.2)),
                (OURS, DRAIN, None),
                (OURS, THESIS, None),
            ]
            comparisons += compare(f"QoS {qos}", samples, pairs, per_second)
    lost = ", ".join(f"{name}: {number}" for name, number in losses.items() if number) or "none by anybody"
    return Report(TITLE, comparisons, (f"Messages lost, over all rounds: {lost}.",))


TITLE = "Gateway end to end: messages per second"


class Load:
    """One round's load, and the account of what arrived.

    Attributes:
        received: The payloads that arrived, in order.
    """

    def __init__(self, generator: Worker, port: int, count: int, qos: int, losses: dict[str, int]) -> None:
        self._generator = generator
        self._losses = losses
        self.port = port
        self.count = count
        self.qos = qos
        self.received: list[bytes] = []

    def start(self) -> None:
        self.received.clear()
        self._generator.start("flood", port=self.port, topics=lamp_topics(LAMPS), count=self.count, qos=self.qos)

    async def wait_received(self) -> float:
        """Return when the last message came, or stopped coming, by ``time.perf_counter``."""
        seen, seen_at = -1, time.perf_counter()
        while len(self.received) < self.count:
            await asyncio.sleep(0.005)
            if len(self.received) != seen:
                seen, seen_at = len(self.received), time.perf_counter()
            elif time.perf_counter() - seen_at > PATIENCE:
                return seen_at
        return time.perf_counter()

    def figure(self, contender: str, ended: float) -> float:
        """Return messages per second, and book what was lost."""
        started = float(self._generator.result()["started"])
        arrived = len({int(payload) for payload in self.received})
        self._losses[f"{contender}, QoS {self.qos}"] = (
            self._losses.get(f"{contender}, QoS {self.qos}", 0) + self.count - arrived
        )
        return arrived / (ended - started)


def in_a_loop(measure: Callable[[Load], Coroutine[None, None, float]], load: Load) -> float:
    return asyncio.run(measure(load))


async def homebot_gateway(load: Load) -> float:
    def make_handler(_devices: Devices, _device: Device) -> Callable[[RawMessage], None]:
        def on_message(message: RawMessage) -> None:
            load.received.append(message.payload)

        return on_message

    async with homebot_listening(load.port, LAMPS, make_handler):
        load.start()
        ended = await load.wait_received()
    return load.figure(OURS, ended)


async def aiomqtt_loop(load: Load) -> float:
    """As its documentation shows it, with MQTT 3.1.1, its default, which is faster there than MQTT 5."""

    async def listen(client: aiomqtt.Client) -> None:
        async for message in client.messages:
            load.received.append(message.payload)

    async with aiomqtt.Client("127.0.0.1", load.port) as client:
        await client.subscribe("bench/+/+/out", qos=load.qos)
        async with in_background(listen(client)):
            load.start()
            ended = await load.wait_received()
    return load.figure(AIOMQTT, ended)


def drain(load: Load) -> float:
    """Read and drop bytes in blocks; at QoS 1 cut out the packet identifiers and acknowledge each block at once."""
    packet = len(publish_packet(lamp_topics(1)[0], b"00000000", load.qos))
    with connect(load.port, "bench-drain") as sock:
        subscribe(sock, "bench/+/+/out", load.qos)
        load.start()
        missing, rest = packet * load.count, b""
        while missing:
            data = sock.recv(64 * 1024)
            missing -= len(data)
            if load.qos:
                rest += data
                whole = len(rest) - len(rest) % packet
                identifiers = (rest[end - 10 : end - 8] for end in range(packet, whole + 1, packet))
                sock.sendall(b"".join(b"\x40\x02" + identifier for identifier in identifiers))
                rest = rest[whole:]
        ended = time.perf_counter()
    load.received.extend(b"%08d" % number for number in range(load.count))
    return load.figure(DRAIN, ended)
