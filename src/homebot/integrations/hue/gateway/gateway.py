"""The gateway to Philips Hue bridges: finds bridges, pairs with them by their button, and works with each.

A bridge is found by an mDNS gateway, whose sightings this gateway follows on the graph, or by a configured address. It
is listed before it is paired, so that ``homebot pair`` can name it.
"""

import re
import socket
from collections.abc import Awaitable, Callable, Collection, Iterator
from functools import partial
from typing import Annotated, ClassVar, Final

import anyio
import anyio.to_thread
from anyio.abc import TaskGroup, TaskStatus
from pydantic import BaseModel, Field, SecretStr

from homebot.config import SecretFile
from homebot.conventions.payload import as_fields, text_of
from homebot.devices import GatewayNames, Sighting
from homebot.devices.gateway_messages import Command
from homebot.errors import HomebotError, LinkError, RefusedError, WireError
from homebot.gateways.announced.device_runner import problems_of
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import Gateway, GatewayContext, GatewaySettings
from homebot.gateways.http_address import http_origin
from homebot.gateways.pairing import PairingFile, PairingServices, UnpairedDevice
from homebot.gateways.pinned_certificate import fetch_certificate, only_certificate
from homebot.graph import DurabilityPolicy, Node, QoSProfile
from homebot.integrations.hue.gateway.bridge import BridgeRunner, bridge_client, create_key
from homebot.plugins import check_extra
from homebot.support.backoff import DEVICE_BACKOFF, BackoffCounter
from homebot.support.isolation import run_as


class HueGatewaySettings(GatewaySettings):
    """The settings of a gateway to Hue bridges.

    Attributes:
        bridges: Addresses of bridges not found by DNS-SD, such as ``192.168.1.20``.
        mdns: The name of the mDNS gateway that finds the others.
        pairings: The file with the keys of paired bridges; by default one beside the index.
    """

    bridges: tuple[Annotated[str, Field(pattern=r"^[^/?#@\s]+$")], ...] = ()
    mdns: str = "mdns"
    pairings: SecretFile | None = None


SERVICE_TYPE: Final = "_hue._tcp"
MAX_BRIDGES: Final = 20
_EACH: Final = 1.0
_SIGHTINGS: Final = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_ID: Final = re.compile(r"[0-9a-f]{16}")
_NONE: Final = "no Hue bridge was found; is the mDNS gateway on, or give its address as `bridges`"


class HueGateway(Gateway):
    """Brings the devices of Hue bridges onto the graph; pairing waits *pressed_within* seconds for the button."""

    pressed_within = 30.0  # for as long as a bridge accepts programs after the press
    Settings: ClassVar[type[BaseModel]] = HueGatewaySettings

    def __init__(self, node: Node, settings: HueGatewaySettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._settings = settings
        self._file = PairingFile.of(self, settings.pairings)
        self._pairings: dict[str, dict[str, object]] = {}
        self._bridges: dict[str, BridgeRunner] = {}
        self._tasks: TaskGroup | None = None
        self._tried = anyio.Event()
        self.devices = PublishedDevices(
            self,
            self._perform,
            settings,
            refresh=self._refresh,
            find_problems=lambda: problems_of(self._bridges.values()),
        )
        PairingServices(self, node)
        names = GatewayNames(settings.mdns)
        node.create_subscription(Sighting, names.received_topics, self._on_sighting, _SIGHTINGS)

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Check the library."""
        del settings
        check_extra('the gateway "hue"', "hue", "aiohttp")

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Work with all bridges until cancelled; ready after the first attempt to reach one."""
        self._tried = anyio.Event()
        self._pairings = await anyio.to_thread.run_sync(self._file.load)
        async with anyio.create_task_group() as self._tasks:
            for key, bridge in self._bridges.items():  # found before it served
                bridge.pairing = self._pairings.get(key, {})
                self._run(bridge.run)
            for key, kept in self._pairings.items():
                self._on_found(key, text_of(kept.get("name")), text_of(kept.get("origin")))
            for address in self._settings.bridges:
                self._run(partial(self._identify, f"https://{address}"))
            if not self._bridges and not self._settings.bridges:
                self._publish_state()
            await self._tried.wait()
            task_status.started()
            await anyio.sleep_forever()  # a bridge may be found at any time

    async def pair(self, key: str, code: str) -> str:
        """Pair with a bridge whose button has just been pressed, or soon will be."""
        bridge = self._bridge(key)
        if code:
            raise RefusedError(f"pairing {bridge.name}", "a bridge has no code: press its button instead")
        origin = bridge.origins[0]
        certificate = await fetch_certificate(origin)
        made: SecretStr | None = None
        async with bridge_client(origin, only_certificate(certificate)) as client:
            with anyio.move_on_after(self.pressed_within):
                while (made := await create_key(client, origin, socket.gethostname())) is None:  # noqa: ASYNC110
                    await anyio.sleep(_EACH)
        if made is None:
            reason = f"its button was not pressed within {self.pressed_within:g} s; press it and try again"
            raise RefusedError(f"pairing {bridge.name}", reason)
        secrets = {"key": made.get_secret_value(), "certificate": certificate}
        await self._save_pairings(bridge, self._pairings | {key: {"name": bridge.name, "origin": origin, **secrets}})
        return bridge.name

    async def unpair(self, key: str) -> str:
        """Forget the key of a bridge, and its devices."""
        bridge = self._bridge(key)
        await self._save_pairings(bridge, {other: kept for other, kept in self._pairings.items() if other != key})
        bridge.forget_devices(f"{bridge.name} is not paired any more")
        return bridge.name

    def unpaired(self) -> Iterator[UnpairedDevice]:
        """Yield the bridges without a key."""
        for key, bridge in self._bridges.items():
            if not bridge.pairing:
                yield UnpairedDevice(device=key, name=bridge.name, takes_code=False, within_s=self.pressed_within)

    def _bridge(self, key: str) -> BridgeRunner:
        bridge = self._bridges.get(key)
        if bridge is None:
            raise RefusedError(f"pairing {key[:100]}", "it is no Hue bridge; pair with the bridge that it belongs to")
        return bridge

    async def _save_pairings(self, bridge: BridgeRunner, pairings: dict[str, dict[str, object]]) -> None:
        """Save the pairings, and reconnect to a bridge."""
        await self._file.keep(pairings)
        self._pairings = pairings
        bridge.pairing = pairings.get(bridge.key, {})
        bridge.restart()

    def _on_sighting(self, sighting: Sighting) -> None:
        facts = {fact.key: fact.value for fact in sighting.metadata}
        address, port = facts.get("ip_address", ""), facts.get("port", "")
        if sighting.kind == "removed" or sighting.service_type != SERVICE_TYPE or not port.isdecimal():
            return
        try:
            origin = http_origin(address, int(port), "https")
        except WireError as exc:
            self.devices.reject(address, b"", str(exc))
        else:
            self._on_found(facts.get("txt_bridgeid", ""), sighting.name, origin)

    def _on_found(self, bridge_id: str, name: str, origin: str) -> None:
        """Start working with a bridge, or remember another of its addresses."""
        key = bridge_id.casefold()
        if key in self._bridges:
            self._bridges[key].add_origin(origin)
        elif not _ID.fullmatch(key):
            self.devices.reject(origin, bridge_id.encode(errors="replace"), "a bridge has 16 hexadecimal digits as id")
        elif len(self._bridges) >= MAX_BRIDGES:
            self.devices.counters.devices_refused += 1
        else:
            name = name or f"Hue bridge {key[-6:]}"
            bridge = self._bridges[key] = BridgeRunner(key, name, origin, self.devices, self._publish_state)
            bridge.pairing = self._pairings.get(key, {})
            self._run(bridge.run)

    def _run(self, work: Callable[[], Awaitable[None]]) -> None:
        if self._tasks is not None:
            self._tasks.start_soon(run_as, self.node.full_name, work)

    async def _identify(self, origin: str) -> None:
        """Ask a configured address for the id of its bridge, until it answers."""
        retries = BackoffCounter(self.node.graph.clock, self.random)
        while True:
            try:
                tls = only_certificate(await fetch_certificate(origin))
                async with bridge_client(origin, tls) as client:
                    about = as_fields(await client.get_json(f"{origin}/api/0/config"))
            except HomebotError as exc:
                self._publish_state(str(exc))
                await anyio.sleep(retries.fail(DEVICE_BACKOFF))
            else:
                self._on_found(text_of(about.get("bridgeid")), text_of(about.get("name")), origin)
                break

    def _publish_state(self, problem: str = "") -> None:
        if any(bridge.is_connected for bridge in self._bridges.values()):
            self.publish_state("active")
        else:
            problems = (f"{bridge.name}: {bridge.problem}" for bridge in self._bridges.values() if bridge.problem)
            unknown = "not connected yet" if self._bridges else _NONE
            self.publish_state("unavailable", next(problems, problem or unknown))
        self._tried.set()

    async def _perform(self, command: Command) -> Collection[str]:
        return await self._bridge_of(command.key).perform(command)

    async def _refresh(self, key: str, part: str) -> None:
        await self._bridge_of(key).refresh(key, part)

    def _bridge_of(self, key: str) -> BridgeRunner:
        bridge = next((bridge for bridge in self._bridges.values() if bridge.has(key)), None)
        if bridge is None:
            raise LinkError(f"the bridge of {key[:100]} is not connected")
        return bridge
