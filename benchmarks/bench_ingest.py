"""Take in a house at start: retained Home Assistant configs on a real Mosquitto -> gateway -> directory.

``python benchmarks/bench_ingest.py [COUNT...] [--gateway] [--profile]`` prints for each count of lights (1,000 and
10,000) the seconds until the directory has them all, processor time each, and memory. Mosquitto has its own defaults,
with which it drops what a client does not read in time; what is missing is told.
"""

from __future__ import annotations

import argparse
import asyncio
import cProfile
import json
import pstats
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Sized
from contextlib import nullcontext

import anyio

import mosquitto as broker
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.log import configure_logging
from raw_mqtt import connect, publish_packet

PATIENCE = 3.0
DEFAULTS = "listener {port} 127.0.0.1\nallow_anonymous true\n"
PINGREQ, PINGRESP = b"\xc0\x00", b"\xd0\x00"
RETAIN = 0x01


def light_config(number: int) -> tuple[str, bytes]:
    """A config as Zigbee2MQTT published it in 2024, so that Home Assistants of then and now take it; about 1 kB."""
    address = f"0x{0x00158D0000000000 + number:016x}"
    config = {
        "availability": [
            {"topic": "zigbee2mqtt/bridge/state", "value_template": "{{ value_json.state }}"},
            {"topic": f"zigbee2mqtt/lamp {number}/availability", "value_template": "{{ value_json.state }}"},
        ],
        "availability_mode": "all",
        "brightness": True,
        "brightness_scale": 254,
        "color_mode": True,
        "command_topic": f"zigbee2mqtt/lamp {number}/set",
        "device": {
            "hw_version": 1,
            "identifiers": [f"zigbee2mqtt_{address}"],
            "manufacturer": "IKEA",
            "model": "TRADFRI bulb E27, white spectrum, globe, opal, 1055 lm",
            "name": f"lamp {number}",
            "sw_version": "1.0.012",
            "via_device": "zigbee2mqtt_bridge_0x00124b0000000000",
        },
        "effect": True,
        "effect_list": ["blink", "breathe", "okay", "channel_change", "finish_effect", "stop_effect"],
        "max_mireds": 454,
        "min_mireds": 250,
        "name": None,
        "object_id": f"lamp_{number}",
        "origin": {"name": "Zigbee2MQTT", "sw": "2.1.1", "url": "https://www.zigbee2mqtt.io"},
        "schema": "json",
        "state_topic": f"zigbee2mqtt/lamp {number}",
        "supported_color_modes": ["color_temp"],
        "unique_id": f"{address}_light_zigbee2mqtt",
    }
    return f"homeassistant/light/{address}/light/config", json.dumps(config).encode()


def seed(port: int, count: int) -> None:
    """Put *count* configs on the broker, and wait until it has them."""
    with connect(port, "bench-seed") as sock:
        for number in range(count):
            packet = bytearray(publish_packet(*light_config(number), 0))
            packet[0] |= RETAIN
            sock.sendall(packet)
        sock.sendall(PINGREQ)
        answer = b""
        while not answer.endswith(PINGRESP):
            answer += sock.recv(100)


async def ingest(port: int, count: int, *, with_directory: bool) -> tuple[int, float, float]:
    """Return how many devices are known in the end, and the seconds and processor seconds until then."""
    graph = Graph()
    async with (
        Node(graph, "mqtt", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        anyio.create_task_group() as tasks,
    ):
        settings = MqttGatewaySettings(url=f"mqtt://127.0.0.1:{port}", act=True)
        MqttGateway.check(settings)  # as `homebot run` does before it starts anything
        started, spent = time.perf_counter(), time.process_time()
        gateway = MqttGateway(gateway_node, settings)
        await tasks.start(gateway.serve)
        known: Sized = gateway._described._registry.by_key
        if with_directory:
            directory = Directory(directory_node, DirectorySettings())
            await tasks.start(directory.serve)
            known = directory.index
        ended, cpu, seen = started, spent, -1
        while seen < count and time.perf_counter() - ended < PATIENCE:
            await asyncio.sleep(0.01)
            if len(known) != seen:
                seen, ended, cpu = len(known), time.perf_counter(), time.process_time()
        tasks.cancel_scope.cancel()
    return seen, ended - started, cpu - spent


def main() -> None:
    options = _parse()
    configure_logging(level="error")
    program = shutil.which("mosquitto", path="/usr/sbin:/usr/local/sbin:/opt/homebrew/sbin:/usr/bin")
    if program is None:
        sys.exit("mosquitto is not installed")
    broker.CONFIG = DEFAULTS
    if len(options.counts) > 1:  # each in a process of its own, or memory would be that of all
        flags = ["--gateway"] if options.gateway else []
        for count in options.counts:
            subprocess.run([sys.executable, __file__, str(count), *flags], check=True)
        return
    (count,) = options.counts
    with broker.mosquitto(program) as port:
        seed(port, count)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        with cProfile.Profile() if options.profile else nullcontext() as profile:
            found, seconds, cpu = asyncio.run(ingest(port, count, with_directory=not options.gateway))
        grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    print(
        f"{found:6,} of {count:6,} lights: {seconds:6.2f} s, {1e3 * cpu / count:.3f} ms CPU each, "
        f"{grown / 1024:5.0f} MiB more ({grown / count:.1f} KiB each)"
    )
    if profile is not None:
        pstats.Stats(profile).sort_stats("tottime").print_stats(35)


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Measure how fast a house is taken in at start.")
    parser.add_argument("counts", nargs="*", type=int, default=[1000, 10_000], metavar="COUNT")
    parser.add_argument("--gateway", action="store_true", help="without the directory")
    parser.add_argument("--profile", action="store_true", help="of one count: where the time goes")
    return parser.parse_args()


if __name__ == "__main__":
    main()
