"""Round trip broker -> app -> broker at 500 messages a second, by the publisher's watch."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

import aiomqtt

from background import in_background
from homebot.devices import Device, Devices, RawMessage
from homebot.mqtt.clients import MqttClientName
from house import homebot_listening, lamp_topics
from mosquitto import mosquitto
from plan import Plan
from raw_mqtt import PUBLISH, PacketStream, connect, publish_packet, subscribe
from report import Aim, Comparison, MissingPeerError, Report, compare, seconds, verdict
from rounds import measure_interleaved
from worker import Worker, worker

__all__ = ["run"]

RATE = 500
MESSAGES = 1000
WORST = 0.010
AIM = Aim("at most", 2)

OURS = "app, native client"
ON_AIOMQTT = "app, aiomqtt client"
AIOMQTT = "bare aiomqtt echo"
RAW = "raw socket echo"

OUT = lamp_topics(1)[0]
IN = OUT.removesuffix("out") + "in"
TITLE = f"Round trip broker - app - broker at {RATE}/s, QoS 1 both ways"


def run(plan: Plan) -> Report:
    if plan.mosquitto is None:
        raise MissingPeerError("Mosquitto is not installed")
    with mosquitto(plan.mosquitto) as port, worker("load_generator.py") as generator:
        paces = {name: Pace(generator, port, plan.count(MESSAGES)) for name in (OURS, ON_AIOMQTT, AIOMQTT, RAW)}
        contenders = {
            OURS: lambda: asyncio.run(homebot_echo(paces[OURS], "native")),
            ON_AIOMQTT: lambda: asyncio.run(homebot_echo(paces[ON_AIOMQTT], "aiomqtt")),
            AIOMQTT: lambda: asyncio.run(aiomqtt_echo(paces[AIOMQTT])),
            RAW: lambda: raw_echo(paces[RAW]),
        }
        samples = measure_interleaved(contenders, plan.rounds(5))
    comparisons = compare("p50", samples, [(OURS, RAW, AIM), (ON_AIOMQTT, RAW, AIM), (OURS, AIOMQTT, None)], seconds)
    notes = [_worst(paces[OURS])]
    for case, fraction in (("p99", 0.99), ("max", 1.0)):
        for peer in (RAW, AIOMQTT):
            ours, theirs = (paces[name].quantiles(fraction) for name in (OURS, peer))
            comparisons.append(Comparison(case, OURS, peer, ours, theirs, seconds))
    notes += [f"{name}: {pace.lost} of {pace.sent} did not come back." for name, pace in paces.items() if pace.lost]
    return Report(TITLE, comparisons, notes)


class Pace:
    """The rounds of one contender.

    Attributes:
        rounds: The round trips of each round, sorted; the first is the warm-up and is not kept.
    """

    def __init__(self, generator: Worker, port: int, count: int) -> None:
        self._generator = generator
        self.port = port
        self.count = count
        self.rounds: list[list[float]] = []
        self.sent = 0
        self.lost = 0

    def start(self) -> None:
        self._generator.start("pace", port=self.port, out=OUT, back=IN, rate=RATE, count=self.count)

    def finish(self) -> float:
        """Wait for the publisher; return the median of the round."""
        round_trips = sorted(self._generator.result()["round_trips"])
        self.rounds.append(round_trips)
        self.sent += self.count
        self.lost += self.count - len(round_trips)
        return _quantile(round_trips, 0.5)

    def quantiles(self, fraction: float) -> list[float]:
        """Return one quantile of each round but the first, which warmed up."""
        return [_quantile(round_trips, fraction) for round_trips in self.rounds[1:]]


async def homebot_echo(pace: Pace, client: MqttClientName) -> float:
    def make_handler(devices: Devices, device: Device) -> Callable[[RawMessage], Awaitable[None]]:
        async def on_message(message: RawMessage) -> None:
            await devices.tell(device, message.text())

        return on_message

    async with homebot_listening(pace.port, 1, make_handler, client=client):
        pace.start()
        return await asyncio.to_thread(pace.finish)


async def aiomqtt_echo(pace: Pace) -> float:
    async def echo(client: aiomqtt.Client) -> None:
        async for message in client.messages:
            await client.publish(IN, message.payload, qos=1)

    async with aiomqtt.Client("127.0.0.1", pace.port) as client:
        await client.subscribe(OUT, qos=1)
        async with in_background(echo(client)):
            pace.start()
            return await asyncio.to_thread(pace.finish)


def raw_echo(pace: Pace) -> float:
    """Acknowledge and answer in one write to the socket, as soon as the bytes are there."""
    with connect(pace.port, "bench-echo") as sock:
        subscribe(sock, OUT, 1)
        pace.start()
        stream, echoed = PacketStream(sock), 0
        while echoed < pace.count:
            for first, body in stream.read():
                if first >> 4 == PUBLISH:
                    echoed += 1
                    sock.sendall(b"\x40\x02" + body[-10:-8] + publish_packet(IN, body[-8:], 1, echoed))
        return pace.finish()


def _worst(pace: Pace) -> str:
    over = [sample for round_trips in pace.rounds[1:] for sample in round_trips if sample > WORST]
    total = sum(len(round_trips) for round_trips in pace.rounds[1:])
    worst = f", the worst {seconds(max(over))}" if over else ""
    return f"Aim: no sample of ours above {seconds(WORST)}: {verdict(not over)}{worst} ({len(over)} of {total})."


def _quantile(ordered: list[Any], fraction: float) -> float:
    return float(ordered[min(len(ordered) - 1, int(fraction * len(ordered)))])
