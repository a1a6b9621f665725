"""A program of your own with a homebot inside: it shows devices as they appear, for two seconds."""

import asyncio

from homebot import Devices, Node, Runtime, configure_logging, parse_config
from homebot.house import thesis_world


async def main() -> None:
    """Run the simulated house and follow its devices."""
    configure_logging(level="warning")
    config = parse_config({"gateways": {"mqtt": {"root": "home425"}}, "door": {"port": 0}}, "example")
    async with Runtime(config, house=thesis_world()) as runtime, Node(runtime.graph, "onlooker") as node:
        try:
            async with asyncio.timeout(2):
                async for change in Devices(node).follow():
                    print(change.kind, change.device.id, "-", change.why)
        except TimeoutError:
            print("that is all")


if __name__ == "__main__":
    asyncio.run(main())
