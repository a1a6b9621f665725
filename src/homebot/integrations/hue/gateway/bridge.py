"""The work with one Hue bridge: connects, publishes its devices, follows changes, and carries out commands.

The event stream is opened before all resources are read, so that no change is missed; both are repeated after each
loss. A bridge sends nothing while nothing changes, so it is queried every ten seconds.

Two requests run at a time: a bridge refuses more than three connections, and the events need one. Commands to lights
start at most ten times a second, those to scenes and groups once a second, in order. Requests for which the bridge was
too busy are repeated; a command without an answer is not.

Source: Philips Hue, CLIP API v2, "Getting started" (system performance), and its reference.
"""

from __future__ import annotations

import ssl
from collections.abc import Awaitable, Callable, Collection, Iterator, Mapping
from contextlib import AbstractAsyncContextManager
from typing import TYPE_CHECKING, Final, TypeVar

import anyio
import anyio.lowlevel
from pydantic import SecretStr

from homebot.clock import Clock
from homebot.conventions.capability_row import writer_of
from homebot.conventions.joint_message import join
from homebot.conventions.payload import as_fields, clean_text, compact_json, parse_json, shown, text_of
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.errors import BusyError, CertificateError, LinkError, PeerError, RefusedError, WireError
from homebot.gateways.address_guard import AddressGuard
from homebot.gateways.announced.device_runner import DeviceRunner
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.http_address import parse_url
from homebot.gateways.long_json import parse_long_json
from homebot.gateways.password_settings import HttpLogin
from homebot.gateways.pinned_certificate import only_certificate
from homebot.integrations.hue.formats.devices import HueDevice, HueService, bridge_identifiers, devices_of
from homebot.integrations.hue.formats.resources import Fields, HueBody, HueResources, at
from homebot.integrations.hue.formats.service_rows import press_of
from homebot.support.backoff import Backoff
from homebot.support.isolation import ungrouped
from homebot.support.limits import RateLimit

if TYPE_CHECKING:
    from homebot.gateways.event_stream import ServerEvent
    from homebot.gateways.http_client import HttpClient
    from homebot.gateways.http_streams import EventStream

AnswerT = TypeVar("AnswerT")

MAX_BYTES: Final = 8 * 1024 * 1024
"""Longest answer or event; all resources of 50 lights are about 200 kB."""

ANSWER_WITHIN: Final = 6.0

_TRIES: Final = 6
_PAUSE: Final = 0.25
_AT_ONCE: Final = 2
_GROUPS: Final = frozenset({"grouped_light", "scene", "smart_scene"})
_NOT_PRESSED: Final = 101
_MAY_NOT: Final = "may not have effect"
"""Part of the error text for a command that was sent nevertheless, such as to a lamp without power."""


def bridge_client(origin: str, tls: ssl.SSLContext, key: SecretStr | None = None) -> HttpClient:
    """Return a client for the bridge at an address, to be opened by ``async with``."""
    from homebot.gateways.http_client import HttpClient  # noqa: PLC0415 - an extra

    login = None if key is None else HttpLogin(origin, "header", "hue-application-key", key)
    guard = AddressGuard((parse_url(origin).host or "",))
    return HttpClient(guard=guard, login=login, tls=tls, time_limit=ANSWER_WITHIN, max_bytes=MAX_BYTES)


class BridgeLink:
    """Requests to a bridge that homebot is paired with, by an open *client* with the application key."""

    def __init__(self, client: HttpClient, origin: str, clock: Clock) -> None:
        self._client = client
        self._origin = origin
        self._clock = clock
        self._turns = anyio.Semaphore(_AT_ONCE)
        self._lights = RateLimit(10.0, 5.0)
        self._groups = RateLimit(1.0, 1.0)

    def events(self) -> AbstractAsyncContextManager[EventStream]:
        """Return the stream of events, for ``async with``."""
        return self._client.events(f"{self._origin}/eventstream/clip/v2")

    async def read(self, kind: str = "") -> object:
        """Return all resources of a type, by default of all types, in the bridge's order."""
        url = f"{self._origin}/clip/v2/resource{kind and f'/{kind}'}"
        answer = await self._ask(lambda: self._client.get(url))
        return as_fields(await parse_long_json(answer.body, MAX_BYTES)).get("data")

    async def change(self, what: str, kind: str, rid: str, body: HueBody) -> None:
        """Change a resource; return when the bridge has accepted it. Raises LinkError, or RefusedError about *what*."""
        url = f"{self._origin}/clip/v2/resource/{kind}/{rid}"
        limit = self._groups if kind in _GROUPS else self._lights
        errors = as_fields(await self._ask(lambda: self._client.send_json("PUT", url, body), limit)).get("errors")
        texts = [text_of(at(error, "description")) for error in errors] if isinstance(errors, list) else []
        problem = next((text for text in texts if _MAY_NOT not in text), "")
        if problem:
            raise RefusedError(what, problem)

    async def _ask(self, send: Callable[[], Awaitable[AnswerT]], limit: RateLimit | None = None) -> AnswerT:
        """Send a request in turn, repeating it while the bridge is too busy; return the answer."""
        attempt = 1
        while True:
            if limit is not None:
                await anyio.sleep(limit.charge(self._clock.monotonic()))
            try:
                async with self._turns:
                    return await send()
            except BusyError:
                if attempt == _TRIES:
                    raise
                await anyio.sleep(_PAUSE * attempt)
                attempt += 1


async def create_key(client: HttpClient, origin: str, name: str) -> SecretStr | None:
    """Return a new application key; None while the bridge's button has not been pressed."""
    answer = await client.send_json("POST", f"{origin}/api", {"devicetype": f"homebot#{clean_text(name, 19)}"})
    first = answer[0] if isinstance(answer, list) and answer else None
    key = at(first, "success", "username")
    if isinstance(key, str) and key:
        return SecretStr(key)
    if at(first, "error", "type") == _NOT_PRESSED:
        return None
    raise RefusedError("pairing", text_of(at(first, "error", "description")) or "the answer of the bridge is unknown")


WATCH_EVERY: Final = 10.0
"""Seconds between checks whether the bridge is still there."""

LOST_BACKOFF: Final = Backoff(first=0.5, factor=2.0, cap=3.0, late_cap=3.0, late_after=300.0, jitter=0.5)
"""After a lost connection. An attempt costs one packet on the local network, even after hours."""

MAX_ADDRESSES: Final = 3
_NO_ACCESS: Final = frozenset({401, 403})


class BridgeRunner(DeviceRunner):
    """The runner of one bridge, which is itself a device, with its id as key.

    Args:
        name: Its name in the list before it has answered.
        on_state: Called after a connection or a failed attempt.

    Attributes:
        origins: The origins of its addresses (``https://192.168.1.20``), in order of attempts.
        pairing: Its application key as ``key``, and its ``certificate`` in PEM; empty without a pairing.
    """

    def __init__(
        self, bridge_id: str, name: str, origin: str, devices: PublishedDevices, on_state: Callable[[], None]
    ) -> None:
        super().__init__(name, bridge_id, devices, LOST_BACKOFF)
        self.origins: tuple[str, ...] = (origin,)
        self.pairing: Mapping[str, object] = {}
        self._on_state = on_state
        self._resources = HueResources()
        self._described: dict[str, HueDevice] = {}
        self._places: dict[str, tuple[str, HueService]] = {}
        self._pressed: dict[str, str] = {}
        self._link: BridgeLink | None = None
        self._has_missed = self._has_answered = False

    @property
    def is_connected(self) -> bool:
        """True while the bridge answers."""
        return self._link is not None

    def has(self, key: str) -> bool:
        """Return whether it has a device."""
        return key in self._described

    def forget_devices(self, why: str) -> None:
        """Remove its devices, except the bridge itself."""
        for key in self._described.keys() - {self.key}:
            self._devices.remove(key, why)
        self._described = {}

    def add_origin(self, origin: str) -> None:
        """Try an address first from now on, and at once if there is no connection."""
        if origin not in self.origins:
            self.origins = (origin, *self.origins)[:MAX_ADDRESSES]
            if self._link is None:
                self.restart()
        self.wake()

    async def work(self) -> None:
        """Connect, and follow the bridge until the connection is lost."""
        key, certificate = text_of(self.pairing.get("key")), self.pairing.get("certificate")
        if not key or not isinstance(certificate, str):
            raise PeerError(f"it is not paired: {self._remedy}")
        failed: LinkError | PeerError = LinkError("it has no address")
        for origin in self.origins:
            self._has_answered = False
            try:
                await self._follow(origin, SecretStr(key), certificate)
            except CertificateError:
                failed = PeerError(f"{origin} has another certificate than at its pairing; if reset, {self._remedy}")
            except LinkError as exc:
                failed = failed if isinstance(failed, PeerError) else exc
            if self._has_answered:
                break  # it is tried again there, before its other addresses
        raise failed

    async def perform(self, command: Command) -> Collection[str]:
        """Carry out a command; return when the bridge has accepted it."""
        if self._link is None:
            raise self.not_connected()
        device = self._described[command.key]
        service = next(service for service in device.services if service.part.id == command.part)
        resource, of_device = self._resources.get(service.id), {"kind": "device", "rid": device.id}

        def write(setting: Command) -> Fields:
            body = writer_of(service.rows, setting.capability)(resource, setting)
            place = (
                of_device if setting.capability == "locate" else {"kind": service.part.advertised, "rid": service.id}
            )
            return {**place, "body": body}

        message, along = join(command, write)
        kind, rid, body = str(message["kind"]), str(message["rid"]), dict(as_fields(message["body"]))
        try:
            await self._link.change(f"{command.capability} for {device.name}", kind, rid, body)
        except RefusedError as exc:
            raise self._explain(exc) from None
        return along

    async def refresh(self, key: str, part: str) -> None:
        """Read a service again; of a group or a scene, the lights in it."""
        if self._link is None:
            raise self.not_connected()
        service = next(service for service in self._described[key].services if service.part.id == part)
        wanted, members = {service.id}, set(service.part.members)
        for device in self._described.values() if members else ():
            names = {own.id: f"id:hue:{device.id}#{own.part.id}" for own in device.services}
            wanted |= {rid for rid, name in names.items() if name in members or f"id:hue:{device.id}" in members}
        listed = await self._link.read("light" if members else service.part.advertised)
        resources = (
            [entry for entry in listed if text_of(as_fields(entry).get("id")) in wanted]
            if isinstance(listed, list)
            else []
        )
        for item, _ in self._apply({"type": "update", "data": resources}):
            await self._publish(item)

    def list_unheard(self) -> None:
        """Publish the bridge with only its id and name."""
        device = GatewayDevice(self.key, self.name, identifiers=bridge_identifiers(self.key), service_type="bridge")
        self._devices.put(device, "it was found", confirmed=False)

    def on_end(self) -> None:
        """Publish the loss of the connection to the bridge and the devices behind it."""
        super().on_end()
        for key in self._described:
            self._devices.report_reachable(key, reachable=False)
        self._on_state()

    @property
    def _remedy(self) -> str:
        return f"press its button, then run `homebot pair '{self.name}'`"

    def _explain(self, exc: RefusedError) -> PeerError:
        return PeerError(f"the bridge has forgotten homebot: {self._remedy}") if exc.code in _NO_ACCESS else exc

    async def _follow(self, origin: str, key: SecretStr, certificate: str) -> None:
        try:
            async with bridge_client(origin, only_certificate(certificate), key) as client:
                link = BridgeLink(client, origin, self.clock)
                async with link.events() as events:
                    self._link, self._has_answered = link, True
                    await self._read_all(link)
                    self.origins = (origin, *(other for other in self.origins if other != origin))
                    self.on_answer()
                    self.report_reachable(reachable=True)
                    self._on_state()
                    with ungrouped():
                        async with anyio.create_task_group() as tasks:
                            tasks.start_soon(self._watch, link)
                            async for event in events:
                                await self._on_event(event)
        except RefusedError as exc:
            raise self._explain(exc) from None
        finally:
            self._link = None

    async def _read_all(self, link: BridgeLink) -> None:
        self._has_missed = False
        self._resources.replace(await link.read())
        self._describe("the bridge listed it", self._resources.ids | {device.id for device in self._described.values()})
        for key, device in tuple(self._described.items()):
            for service in device.services:
                await self._report(key, service, None, is_old=device.reachable is False)
            await anyio.lowlevel.checkpoint()

    async def _watch(self, link: BridgeLink) -> None:
        """Check that the bridge is there, confirm the devices that it can reach, and read missed changes."""
        while True:
            await anyio.sleep(WATCH_EVERY)
            await (self._read_all(link) if self._has_missed else link.read("bridge"))
            await self._devices.confirm(self._described, "the bridge reaches it")

    def _describe(self, why: str, ids: Collection[str]) -> None:
        """Publish the devices with these ids, and remove those that the bridge no longer has."""
        devices = {
            self.key if device.is_bridge else device.id: device for device in devices_of(self._resources, sorted(ids))
        }
        before = {key for key, device in self._described.items() if device.id in ids}
        for gone in before.difference(devices.keys()):
            del self._described[gone]
            self._devices.remove(gone, "the bridge no longer has it")
        self._described |= devices
        self._places = {
            service.id: (key, service) for key, device in self._described.items() for service in device.services
        }
        self._pressed = {rid: at for rid, at in self._pressed.items() if rid in self._places}
        name = next((device.name for device in devices.values() if device.is_bridge and device.name), self.name)
        is_renamed, self.name = name != self.name, name  # all devices have it
        for key, device in (self._described if is_renamed else devices).items():
            self._put(key, device, why)
            if not device.is_bridge:
                self._devices.report_reachable(key, reachable=device.reachable)

    def _put(self, key: str, device: HueDevice, why: str) -> None:
        published = GatewayDevice(
            key,
            device.name or key,
            tuple(service.part for service in device.services),
            device.metadata if device.is_bridge else {**device.metadata, "via_device": self.name},
            device.identifiers,
            authenticated=True,  # by the bridge's certificate, pinned when its button was pressed
            area=device.area,
            service_type="bridge" if device.is_bridge else "",
        )
        self._devices.put(published, why, confirmed=device.reachable is not False)

    async def _on_event(self, event: ServerEvent) -> None:
        """Apply one event, with the changes of many resources."""
        await anyio.lowlevel.checkpoint()
        payload = event.data.encode()
        try:
            parts = parse_json(payload, len(payload) or 1)
        except WireError as exc:
            if self._admits(self.key):
                self.reject(payload, str(exc))
            return
        events = parts if isinstance(parts, list) else []
        changes = [change for event in events for change in self._apply(as_fields(event))]
        if described := frozenset[str]().union(*(ids for _, ids in changes)):  # once all their resources are known
            self._describe("the bridge reported it", described)
        for item, _ in changes:
            await self._publish(item)

    def _apply(self, event: Fields) -> Iterator[tuple[Fields, frozenset[str]]]:
        """Apply the valid changes of an event; yield each with the ids of resources whose description has changed."""
        kind, items = text_of(event.get("type")), event.get("data")
        for item in items if isinstance(items, list) else ():
            rid = text_of(as_fields(item).get("id"))
            source = self._places[rid][0] if rid in self._places else shown(rid)
            if not self._admits(source):
                continue
            try:
                yield as_fields(item), self._resources.change(kind, item)
            except WireError as exc:
                self._devices.reject(source, compact_json(item).encode(), str(exc))

    async def _publish(self, item: Fields) -> None:
        key, service = self._places.get(text_of(item.get("id")), ("", None))
        if service is not None:
            self._put(key, self._described[key], "it reported")
            await self._devices.deliver_raw(key, compact_json(item).encode())
            await self._report(key, service, item)

    def _admits(self, source: str) -> bool:
        admitted = self._devices.admits(source)
        self._has_missed = self._has_missed or not admitted
        return admitted

    async def _report(self, key: str, service: HueService, change: Fields | None, *, is_old: bool = False) -> None:
        """Report the values in a change, or all values for None."""
        resource = self._resources.get(service.id)
        values: dict[tuple[str | int, ...], dict[str, PlainValue]] = {}
        for row in service.rows:
            if row.read is not None and (change is None or not change.keys().isdisjoint(row.watched)):
                values.setdefault(row.watched, {})[row.capability] = row.read(resource)
        for together in values.values():
            await self._devices.report(key, together, service.part.id, retained=is_old)
        press, time = press_of(change or {})
        if press and (not time or self._pressed.get(service.id) != time):
            self._pressed[service.id] = time
            await self._devices.report(key, {"press": press}, service.part.id)
