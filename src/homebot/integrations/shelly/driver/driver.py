"""The driver for Shelly devices, and its table ``[gateways.mdns.drivers.shelly]``.

Source: Shelly Gen2+ API, Overview, Common Device Traits (mDNS).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, ClassVar, Final

import anyio
from pydantic import Field, SecretStr

from homebot.conventions.description import DeviceAnnounced
from homebot.conventions.payload import Readings, as_fields, clean_text, compact_json, text_of
from homebot.devices.gateway_messages import Command
from homebot.devices.identity import identifiers, in_pairs
from homebot.errors import LinkError, PeerError, RefusedError, WireError
from homebot.gateways.announced.device_runner import DriverHost
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.drivers.base import Driver, DriverSettings, FoundService, first_answer
from homebot.gateways.http_address import http_origin
from homebot.gateways.password_settings import PasswordSettings
from homebot.integrations.shelly.driver.rpc_link import RpcLink, wants_password
from homebot.integrations.shelly.formats.gen2 import MAX_ANSWER_BYTES
from homebot.integrations.shelly.formats.gen2_component import COMPONENTS, components_from
from homebot.integrations.shelly.formats.gen2_device import ANSWERS, AnswerKind, is_prefix
from homebot.integrations.shelly.formats.gen2_rpc import Gen2RpcDevice, PartKey, RpcLogin, is_setup_change
from homebot.integrations.shelly.formats.status import Fields
from homebot.support.isolation import ungrouped

if TYPE_CHECKING:
    from homebot.gateways.http_client import HttpClient

ASK_AGAIN: Final = 300.0
"""Seconds between requests for the whole status, as a device without measurements may be silent for days."""

WATCH_EVERY: Final = 18.0
"""Seconds between requests to a device of the first generation, which pushes nothing over HTTP."""

PAUSE: Final = 5.0
"""Least seconds between rounds of requests, however often the device reports changes of its setup."""

BLUETOOTH_SILENCE: Final = 24 * 3600.0
"""Seconds for which a Bluetooth device behind it may be silent; some send every six hours."""


class ShellyDriverSettings(PasswordSettings, DriverSettings):
    """The passwords of Shelly's devices, for the user ``admin``; its own is for devices without another.

    Attributes:
        devices: Passwords of single devices, by the id that is printed on each: ``shellyplus1-a8032abe54dc``.
    """

    devices: Mapping[str, PasswordSettings] = Field(default_factory=dict)

    def check_secrets(self) -> None:
        """Read all passwords once."""
        self.read_password()
        for device_id in self.devices:
            self.password_of(device_id)

    def password_of(self, device_id: str) -> SecretStr | None:
        """Return the password of a device; None if it has none.

        Raises:
            UsageError: It cannot be read; names the key.
        """
        for name, own in self.devices.items():
            if name.casefold() == device_id.casefold():
                return own.read_password(f"devices.{name}.")
        return self.read_password()


class ShellyDriver(Driver):
    """One Shelly device of the second generation or later; for the first, only model and firmware are listed."""

    service_types: ClassVar[frozenset[str]] = frozenset({"_shelly._tcp.local."})
    Settings: ClassVar[type[DriverSettings]] = ShellyDriverSettings
    libraries: ClassVar[tuple[str, ...]] = ("aiohttp",)
    settings: ShellyDriverSettings

    def __init__(self, service: FoundService, settings: DriverSettings, host: DriverHost) -> None:
        super().__init__(service, settings, host)
        self._device: Gen2RpcDevice | None = None
        self._described: tuple[GatewayDevice, ...] = ()
        self._rpc: RpcLink | None = None
        self._setup_changed = anyio.Event()
        self._components_known = anyio.Event()
        self._offset = 0

    async def run(self) -> None:
        """Connect, and report the device's states, until cancelled."""
        async with self.http_client(MAX_ANSWER_BYTES) as client:
            origin, about = await self._probe(client)
            if "gen" not in about and "type" in about:
                await self._watch_first_generation(client, origin, about)
            device_id = about.get("id")
            if not isinstance(device_id, str) or not is_prefix(device_id):
                raise WireError(f"{self.service.name} does not answer like a Shelly device")
            async with client.websocket(f"{origin}/rpc", max_bytes=MAX_ANSWER_BYTES) as socket:
                self._device = device = Gen2RpcDevice(device_id)
                device.record_answer("info", about, len(compact_json(about)))
                login = self._login(device, device_id, about)
                on_notification = partial(self._on_notification, device)
                self._rpc = RpcLink(socket, device_id, login, on_notification, self.host.reject)
                try:
                    await self._live(device, self._rpc)
                finally:
                    self._rpc = None
                    self._components_known.set()

    async def perform(self, command: Command) -> Collection[str]:
        """Carry out a command; return when the device has accepted it."""
        rpc, device = self._rpc, self._device
        if rpc is None or device is None:
            raise LinkError(f"{self.service.name} is not connected")
        values = {one.capability: one.value.plain() for one in command.singly()}
        key = device.id if command.key == self.service.key else command.key
        if key != device.id:
            await self._components_known.wait()
        calls, names = device.calls((key, command.part), values, command.transition)
        for method, params in calls:
            await rpc.call(method, params)
        return names

    async def refresh(self, key: str, part: str) -> None:
        """Read the status of all parts again."""
        del key, part
        rpc, device = self._rpc, self._device
        if rpc is None or device is None:
            raise LinkError(f"{self.service.name} is not connected")
        await rpc.call(ANSWERS["status"], on_answer=partial(self._on_answer, device, "status"))

    async def _probe(self, client: HttpClient) -> tuple[str, Fields]:
        """Return the address that answers, and the facts available without a password."""

        async def ask(address: str) -> tuple[str, Fields]:
            origin = http_origin(address, self.service.port)
            return origin, as_fields(await client.get_json(f"{origin}/shelly"))

        return await first_answer(self.service.name, self.service.addresses, ask)

    def _login(self, device: Gen2RpcDevice, device_id: str, about: Fields) -> RpcLogin | None:
        password = self.settings.password_of(device_id)
        if password is not None:
            return RpcLogin(password)
        if about.get("auth_en") is True:
            self._describe(device)
            raise RefusedError(device_id, wants_password(has_one=False), 401)
        return None

    async def _live(self, device: Gen2RpcDevice, rpc: RpcLink) -> None:
        try:
            with ungrouped():
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(rpc.receive)
                    while True:
                        await self._ask(device, rpc)
                        with anyio.move_on_after(ASK_AGAIN):
                            await self._setup_changed.wait()
        except (LinkError, PeerError) as exc:
            raise rpc.end or exc from None

    async def _ask(self, device: Gen2RpcDevice, rpc: RpcLink) -> None:
        self._setup_changed = anyio.Event()
        for kind, method in ANSWERS.items():
            await rpc.call(method, on_answer=partial(self._on_answer, device, kind))
        await self._ask_components(device, rpc)
        await anyio.sleep(PAUSE)

    async def _ask_components(self, device: Gen2RpcDevice, rpc: RpcLink) -> None:
        """Request the components added to the device; older firmware has none."""
        self._offset, asked = 0, -1
        while self._offset > asked:
            asked = self._offset
            try:
                await rpc.call(COMPONENTS, components_from(asked), partial(self._on_components, device))
            except RefusedError:
                self._components_known.set()

    async def _on_answer(self, device: Gen2RpcDevice, kind: AnswerKind, answer: Fields, frame: bytes) -> None:
        device.record_answer(kind, answer, len(frame))
        if kind == "status":
            self._describe(device)
            await self._report(device.read_status(frame))

    async def _on_components(self, device: Gen2RpcDevice, page: Fields, _frame: bytes) -> None:
        self._offset = device.add_page(page)
        if self._offset == 0:
            self._components_known.set()
            self._describe(device)
            await self._report(device.read_status(device.components_status()))

    async def _on_notification(self, device: Gen2RpcDevice, frame: Fields, payload: bytes) -> None:
        if not self._described:
            return
        await self.host.deliver_raw(payload)
        await self._report(device.read_notification(payload))
        if is_setup_change(frame):
            self._setup_changed.set()

    async def _report(self, of_parts: Iterable[tuple[PartKey, Readings]]) -> None:
        for (key, part), readings in of_parts:
            await self.host.report(readings, part, self._own_key(key))

    def _describe(self, device: Gen2RpcDevice) -> None:
        """Publish the descriptions, or only that the device is still there if nothing has changed."""
        if news := device.describe():
            self._described = tuple(self._gateway_device(one, device.stale_after) for one in news)
        if self._described:
            self.host.describe(self._described[0])
        if self._components_known.is_set():  # on a new link the devices behind it are not gone, only not read yet
            self.host.describe_behind(self._described[1:])

    def _gateway_device(self, news: DeviceAnnounced, stale_after: float) -> GatewayDevice:
        return GatewayDevice(
            key=self._own_key(news.key) or self.service.key,
            name=news.name,
            parts=tuple(one.part.model_copy(update={"reads": (), "writes": ()}) for one in news.parts),
            metadata=news.facts,
            identifiers=news.identifiers,
            stale_after=stale_after if news.implies_alive else BLUETOOTH_SILENCE,
            sleeps=stale_after > 0,
            expiries={one.part.id: one.expiries for one in news.parts if one.expiries},
        )

    def _own_key(self, key: str) -> str:
        """Return the key of a device behind this one; empty for this one."""
        return "" if self._device is None or key == self._device.id else key

    async def _watch_first_generation(self, client: HttpClient, origin: str, about: Fields) -> None:
        """Publish the description of the device while it answers."""
        self.host.describe(_first_generation(self.service, about))
        while True:
            await anyio.sleep(WATCH_EVERY)
            await client.get_json(f"{origin}/shelly")


def _first_generation(service: FoundService, about: Fields) -> GatewayDevice:
    """Return a device of the first generation, which can be used over MQTT.

    Source: Shelly Gen1 API, Common HTTP API, /shelly.
    """
    facts: Mapping[str, str] = {
        "manufacturer": "Shelly",
        "model": text_of(about.get("type")),
        "sw_version": text_of(about.get("fw")),
        "generation": "1",
    }
    return GatewayDevice(
        service.key,
        clean_text(service.name),
        metadata={name: value for name, value in facts.items() if value},
        identifiers=identifiers((in_pairs(text_of(about.get("mac"))),)),
    )
