"""Chapter 8 of the thesis in one command, in half a minute: its three programs, two lamps and a window.

``--mqtt mqtt://127.0.0.1:1883`` uses your broker, as Mosquitto, else it has one of its own. ``--service-first`` starts
the light service before the first message.
"""

import argparse
import asyncio
import os
import sys
from contextlib import AsyncExitStack
from pathlib import Path
from urllib.parse import urlsplit

from homebot.mqtt.broker import Broker

HERE = Path(__file__).parent
PROGRAMS = [str(HERE / f"{name}.py") for name in ("mqtt_gateway", "discovery_manager", "experiment")]


async def main() -> int:
    """Run the programs on one graph, and return their exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mqtt", metavar="URL", default="")
    parser.add_argument("--service-first", action="store_true")
    options = parser.parse_args()
    async with AsyncExitStack() as stack:
        url = urlsplit(options.mqtt)
        host, port = url.hostname, url.port or 1883
        if not host:
            broker = await stack.enter_async_context(Broker())
            host, port = "127.0.0.1", broker.port
        more = ["--", "--service-first"] if options.service_first else []
        command = [sys.executable, "-m", "homebot.compat", "--interfaces", str(HERE / "interfaces"), *PROGRAMS, *more]
        environment = {**os.environ, "MQTT_HOST": host, "MQTT_PORT": str(port)}
        return await (await asyncio.create_subprocess_exec(*command, env=environment)).wait()


if __name__ == "__main__":
    sys.exit(asyncio.run(main()))
