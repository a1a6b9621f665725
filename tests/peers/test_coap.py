"""The gateway for CoAP, and the simulated devices, against libcoap: another implementation on another machine."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.gateways.coap.watched import watched_gateway
from tests.patience import PATIENCE
from tests.peers.network import INTERFACE, Lan, Machine, Program, missing_programs
from tests.simulated.coap_devices import CoapDevice

from homebot.house.dialect import DeviceState, SimulatedDeviceInfo

GROUPS = (("224.0.1.187", INTERFACE), ("ff02::fd", INTERFACE))
pytestmark = pytest.mark.skipif(
    bool(missing_programs("coap-client-notls", "coap-server-notls", "coap-rd-notls")),
    reason="libcoap's programs are not installed (apt-get install libcoap3-bin)",
)


@asynccontextmanager
async def lamp(host: str, port: int = 5683, directory: str = "") -> AsyncIterator[tuple[CoapDevice, list[str]]]:
    """A simulated lamp that does what it is told."""
    told: list[str] = []

    def obey(command: str) -> None:
        told.append(command)
        device.publish(DeviceState(text=command, is_on=command == "on"))

    info = SimulatedDeviceInfo(home="house", kind="lamp", device_id="Hall", service_type="light", room="hall")
    device = CoapDevice(info, obey, host=host, port=port, directory=directory, groups=GROUPS)
    device.begin(DeviceState(text="off"), has_power=True)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(device.live)
        yield device, told
        tasks.cancel_scope.cancel()


async def shows(program: Program, text: str) -> None:
    """Wait until *program* has printed *text*; libcoap's client ends no line."""
    with anyio.fail_after(PATIENCE):
        while text not in "".join(program.printed):  # noqa: ASYNC110 - it waits for whole lines
            await anyio.sleep(0.05)


@pytest.mark.newest("coap")
async def test_libcoaps_client_reads_writes_and_observes_a_simulated_lamp(lan: Lan, hub: Machine) -> None:
    phone = lan.machine("phone")
    async with lamp(hub.address) as (device, told):
        base = f"coap://{hub.address}"
        links = await phone.run("coap-client-notls", f"{base}/.well-known/core")
        assert '</on>; ct="50"; rt="light"; if="core.a"; obs' in links.replace(";", "; ").replace(";  ", "; ")
        assert '"title": "Hall"' in await phone.run("coap-client-notls", f"{base}/.well-known/wot")
        observe = phone.program("coap-client-notls", "-s", "60", f"{base}/on")
        async with observe as observer:
            await shows(observer, "false")
            await phone.run("coap-client-notls", "-m", "put", "-t", "50", "-e", "true", f"{base}/on")
            await shows(observer, "true")
            device.publish(DeviceState(text="off"))
            await shows(observer, "truefalse")
    assert told == ["on"]


async def test_libcoaps_server_is_found_by_multicast_and_read(lan: Lan, hub: Machine) -> None:
    """Its clock can be observed: it goes on."""
    server = lan.machine("server")
    settings: dict[str, object] = {"interfaces": [INTERFACE], "groups": ["ipv4"], "ask_every": 5}
    async with server.program("coap-server-notls", "-g", "224.0.1.187"), watched_gateway(**settings) as watcher:
        key = f"coap://{server.address}"
        found = await watcher.sighting(lambda one: one.key == key)
        assert found.kind in {"appeared", "updated"}
        first = await watcher.reported("value", lambda one: isinstance(one, str))
        await watcher.reported("value", lambda one: one != first)


@pytest.mark.parametrize("version", ["ipv4", "ipv6"])
async def test_a_lamp_is_found_by_multicast_and_obeys(lan: Lan, hub: Machine, version: str) -> None:
    """Both on this machine, over its interface; the address over IPv6 is link-local."""
    del lan
    async with (
        lamp("::") as (_, told),
        watched_gateway(interfaces=[INTERFACE], groups=[version], ask_every=5) as watcher,
    ):
        found = await watcher.sighting(lambda one: bool(one.parts))
        assert found.key.startswith(f"coap://{hub.address}" if version == "ipv4" else "coap://[fe80::")
        assert await watcher.reported("on_off", False) is False
        assert (await watcher.tell(found.key, "on_off", True)).success
        assert await watcher.reported("on_off", True) is True
        assert told == ["on"]


async def test_a_lamp_registers_in_libcoaps_resource_directory(lan: Lan, hub: Machine) -> None:
    """It has no lookup, which RFC 9176 demands; the gateway says so, and finds the lamp by its address meanwhile."""
    elsewhere = lan.machine("rd")
    directory = f"coap://{elsewhere.address}"
    async with elsewhere.program("coap-rd-notls", "-A", elsewhere.address), lamp(hub.address, directory=directory):
        listed = ""
        with anyio.fail_after(PATIENCE):
            while "</rd/" not in listed:  # the registration has a resource of its own
                listed = await elsewhere.run("coap-client-notls", f"{directory}/.well-known/core")
        device = f"coap://{hub.address}"
        async with watched_gateway(resource_directory=[directory], devices=[device]) as watcher:
            await watcher.sighting(lambda one: one.key == device and bool(one.parts))
            assert watcher.gateway.devices.problems == (
                f"the resource directory {directory} cannot be read: looking endpoints up at {directory} was refused:"
                " it offers no core.rd-lookup-ep",
            )
