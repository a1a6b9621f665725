"""The gateway beyond the contract, on aiocoap and loopback: its own directory, fixed addresses, devices that leave."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from urllib.parse import quote

import aiocoap
import anyio
import pytest
from aiocoap import resource
from tests.gateways.coap.watched import watched_gateway
from tests.patience import PATIENCE
from tests.ports import reserve_datagram_port
from tests.simulated.coap_devices import CoapDevice
from tests.simulated.coap_directory import served_directory

from homebot.devices.gateway_messages import REACHABLE
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo

pytestmark = pytest.mark.rooms("things")


@asynccontextmanager
async def device(kind: str = "lamp", directory: str = "") -> AsyncIterator[CoapDevice]:
    def obey(command: str) -> None:
        level = float(command) if command not in {"on", "off"} else made.state.brightness
        made.publish(DeviceState(text=command, is_on=command != "off", brightness=level))

    info = SimulatedDeviceInfo(home="house", kind=kind, device_id="Hall", service_type=kind, room="hall")
    made = CoapDevice(info, obey, directory=directory)
    made.begin(DeviceState(text="off", value=120.0), has_power=True)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(made.live)
        yield made
        tasks.cancel_scope.cancel()


async def test_a_sensor_without_a_description_is_known_by_its_resource_type() -> None:
    async with device("lux") as sensor, watched_gateway(devices=[sensor.uri]) as watcher:
        found = await watcher.sighting(lambda one: bool(one.parts))
        assert found.parts[0].service_type == "light_sensor"
        await watcher.reported("illuminance", 120.0)
        sensor.publish(DeviceState(text="300", value=300.0))
        await watcher.reported("illuminance", 300.0)


async def test_a_device_that_loses_its_power_is_unreachable_stays_and_comes_back() -> None:
    """A command to it fails at once; it is there again by itself."""
    async with device() as lamp, watched_gateway(devices=[lamp.uri]) as watcher:
        await watcher.sighting(lambda one: bool(one.parts))
        await watcher.reported(REACHABLE, True)
        lamp.power(on=False)
        with anyio.fail_after(PATIENCE):
            while lamp._context is not None:  # noqa: ASYNC110 - it goes without a word
                await anyio.sleep(0.01)
        response = await watcher.tell(lamp.uri, "on_off", True)
        assert (response.success, response.problem) == (False, "unreachable")
        await watcher.reported(REACHABLE, False)
        assert watcher.gateway.devices.keys == (lamp.uri,)
        lamp.power(on=True)
        await watcher.reported(REACHABLE, True)
        assert (await watcher.tell(lamp.uri, "on_off", True)).success


async def test_a_device_that_is_not_there_yet_is_listed_and_unreachable() -> None:
    uri = f"coap://127.0.0.1:{reserve_datagram_port()}"
    async with watched_gateway(devices=[uri]) as watcher:
        found = await watcher.sighting(lambda one: one.key == uri)
        assert (found.parts, found.confirmed) == ((), False)
        await watcher.reported(REACHABLE, False)
        assert (await watcher.states().receive()).state == "active"


@pytest.mark.parametrize("name", ["other", "{uri}", "{uri}/td"])
async def test_a_configured_device_is_never_renamed_or_removed_by_a_registration(name: str) -> None:
    """Here by a program on this computer, which may register for other addresses."""
    port = reserve_datagram_port()
    address = f"127.0.0.1:{port}"
    async with (
        served_directory("127.0.0.1", port),
        device() as lamp,
        watched_gateway(resource_directory=[f"coap://{address}"], devices=[lamp.uri]) as watcher,
    ):
        await watcher.sighting(lambda one: one.key == lamp.uri and bool(one.parts))
        ep = quote(name.format(uri=lamp.uri), safe="")
        registered = f"coap://{address}/rd?ep={ep}&lt=1&base={lamp.uri}"
        assert (await post(registered, b"</on>;rt=light")).code.dotted == "2.01"
        await anyio.sleep(2.5)  # the lease is over
        assert watcher.gateway.devices.keys == (lamp.uri,)
        assert (await watcher.tell(lamp.uri, "on_off", True)).success
        await watcher.reported("on_off", True)


async def test_links_that_end_with_a_comma_are_accepted() -> None:
    """Small devices print a comma after each link."""
    async with served_links(b"</3303/0/5700>;ct=0;obs,") as uri, watched_gateway(devices=[uri]) as watcher:
        found = await watcher.sighting(lambda one: bool(one.parts))
        assert found.parts[0].service_type == "temperature_sensor"
        await watcher.reported("temperature", 21.5)


async def test_the_doctor_names_a_device_that_breaks_the_rules() -> None:
    async with served_links(b"<<") as uri, watched_gateway(devices=[uri]) as watcher:
        await watcher.sighting(lambda one: one.key == uri)
        (problem,) = (await watcher.health()).troubles
        assert problem == f"{uri}: a link begins with <, got '<<'"


@asynccontextmanager
async def served_links(links: bytes) -> AsyncIterator[str]:
    """Serve a thermometer whose list of links is *links*."""

    class Core(resource.Resource):  # type: ignore[misc] # the library has no types
        async def render_get(self, _: aiocoap.Message) -> aiocoap.Message:
            return aiocoap.Message(payload=links, content_format=40)

    class Temperature(resource.Resource):  # type: ignore[misc] # likewise
        async def render_get(self, _: aiocoap.Message) -> aiocoap.Message:
            return aiocoap.Message(payload=b"21.5", content_format=0)

    site, port = resource.Site(), reserve_datagram_port()
    site.add_resource([".well-known", "core"], Core())
    site.add_resource(["3303", "0", "5700"], Temperature())
    context = await aiocoap.Context.create_server_context(site, bind=("127.0.0.1", port), transports=["udp6"])
    try:
        yield f"coap://127.0.0.1:{port}"
    finally:
        await context.shutdown()


async def post(uri: str, payload: bytes, method: aiocoap.Code = aiocoap.POST) -> aiocoap.Message:
    context = await aiocoap.Context.create_client_context(transports=["udp6"])
    message = aiocoap.Message(code=method, uri=uri, payload=payload)
    if payload:
        message.opt.content_format = 40
    answer = await context.request(message, handle_blockwise=False).response
    await context.shutdown()
    return answer
