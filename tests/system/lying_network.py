"""Hosts on a network of a test: one that lies about the addresses of others, and one that is lied about."""

import sys

import aiocoap
import anyio
from aiocoap import resource
from tests.conventions.coap.link_writer import format_links
from tests.gateways.served import served
from tests.simulated.coap_devices import CoapDevice
from tests.things.directory import ThingDirectoryServer
from tests.things.thing import ServedThing

from homebot.conventions.coap.link_format import WebLink
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.things.formats.parse import CONTEXT

DIRECTORY_PORT, LAMP_PORT = 8081, 5700


def _obey(command: str) -> None:
    del command


def _info(name: str) -> SimulatedDeviceInfo:
    return SimulatedDeviceInfo("house", "lamp", name, "lights", "hall")


def _described(number: int, href: str) -> dict[str, object]:
    on = {"type": "boolean", "@type": "OnOffProperty", "forms": [{"href": href}]}
    return {
        "@context": CONTEXT,
        "id": f"urn:dev:lie:{number}",
        "title": f"Lie {number}",
        "securityDefinitions": {"open": {"scheme": "nosec"}},
        "security": "open",
        "properties": {"on": on},
    }


class _Links(resource.Resource):  # type: ignore[misc] # the library has no types
    def __init__(self, *links: WebLink) -> None:
        super().__init__()
        self._links = links

    async def render_get(self, _: aiocoap.Message) -> aiocoap.Message:
        return aiocoap.Message(payload=format_links(self._links), content_format=40)


async def victim(*arguments: str) -> None:
    """Be a lamp that the owner has configured."""
    (own,) = arguments
    lamp = CoapDevice(_info("Victim"), _obey, host=own, port=5683)
    lamp.begin(DeviceState(text="off"), has_power=True)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(lamp.live)
        print("ready", flush=True)


async def liar(*arguments: str) -> None:
    """List two lamps of its own among lies."""
    own, *lies = arguments
    directory = ThingDirectoryServer(own, DIRECTORY_PORT)
    lamp = ServedThing(_info("Honest"), _obey, address=own)
    lamp.begin(DeviceState(text="off"), has_power=True)
    coap_lamp = CoapDevice(_info("Honest CoAP"), _obey, host=own, port=LAMP_PORT)
    coap_lamp.begin(DeviceState(text="off"), has_power=True)
    listed = [*(f"coap://{one}" for one in lies), f"coap://{own}:{LAMP_PORT}"]
    site = resource.Site()
    site.add_resource([".well-known", "core"], _Links(WebLink("/ep", (("rt", "core.rd-lookup-ep"),))))
    site.add_resource(
        ["ep"],
        _Links(*(WebLink(f"/rd/{at}", (("ep", f"listed{at}"), ("base", one))) for at, one in enumerate(listed))),
    )
    context = await aiocoap.Context.create_server_context(site, bind=(own, 5683), transports=["udp6"])
    async with served(directory, lamp), anyio.create_task_group() as tasks:
        tasks.start_soon(coap_lamp.live)
        for number, one in enumerate(lies):
            directory.register(_described(number, f"http://{one}/on"))
        directory.register(lamp.description())
        print("has lied", flush=True)
        await anyio.sleep_forever()
    await context.shutdown()


if __name__ == "__main__":
    anyio.run({"victim": victim, "liar": liar}[sys.argv[1]], *sys.argv[2:])
