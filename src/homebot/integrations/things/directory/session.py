"""The things of one directory: listed, followed and removed.

The events of the directory are subscribed to before its list is read, so that nothing is missed. A directory without
events is polled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from hashlib import blake2b
from typing import Final

import anyio
from anyio.abc import TaskGroup
from yarl import URL

from homebot.conventions.long_json import is_longer_than
from homebot.conventions.payload import MAX_ANNOUNCEMENT_BYTES, parse_json
from homebot.devices.gateway_messages import Command
from homebot.errors import RefusedError, UnableError, WireError
from homebot.gateways.address_guard import AddressGuard, guard_for
from homebot.gateways.announced.device_runner import DeviceRunner, problems_of
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.http_client import TIME_LIMIT, HttpClient
from homebot.gateways.password_settings import read_logins
from homebot.integrations.things.directory.directory_client import DirectoryReader
from homebot.integrations.things.directory.documents import id_of, lifetime_of, read_event, text_of
from homebot.integrations.things.directory.settings import ThingDirectorySettings
from homebot.integrations.things.formats.parse import read_thing
from homebot.integrations.things.formats.thing import Thing
from homebot.integrations.things.http.http_port import HTTP_BINDING, HttpThingPort, login_at
from homebot.integrations.things.http.thing_device import ThingDevice, describe_thing
from homebot.support.backoff import DEVICE_BACKOFF
from homebot.support.isolation import run_as, ungrouped


class ListedThing(DeviceRunner):
    """A thing listed by a directory, confirmed when it answers itself.

    Args:
        device: Its device, which is published once it has answered, or has failed to for a moment.
        connecting: The limit of concurrent connection attempts.
    """

    def __init__(
        self,
        thing: Thing,
        device: GatewayDevice,
        port: HttpThingPort,
        devices: PublishedDevices,
        *,
        poll_every: float,
        connecting: anyio.CapacityLimiter,
    ) -> None:
        super().__init__(device.name, device.key, devices, DEVICE_BACKOFF)
        self._device = device
        self._port = port
        self._connecting = connecting
        self._answered = anyio.Event()
        self._thing = ThingDevice(thing, device, port, self, poll_every)

    async def run(self) -> None:
        """Work with the thing until stopped."""
        async with self._port:
            await super().run()

    async def work(self) -> None:
        """Use the thing, and check at intervals whether it is still there."""
        self._answered = anyio.Event()
        async with anyio.create_task_group() as tasks:
            async with self._connecting:
                tasks.start_soon(run_as, "a thing", self._thing.run)
                with anyio.move_on_after(TIME_LIMIT):
                    await self._answered.wait()
            tasks.start_soon(run_as, "a thing", partial(self._port.watch, self.confirm))

    async def perform(self, command: Command) -> None:
        """Carry out a command; return when the thing has accepted it."""
        await self._thing.perform(command)

    def describe(self, device: GatewayDevice) -> None:
        """Do nothing: the directory described it."""

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        """Publish whether the thing can be reached, and if so, that it was heard."""
        if reachable:
            self.confirm()
        super().report_reachable(reachable=reachable, part=part)

    def confirm(self) -> None:
        """Publish that the thing itself was heard, unless it has been removed."""
        self._answered.set()
        if not self.is_stopped:
            self.on_answer()
            self._devices.put(self._device, "it answers")

    def list_unheard(self) -> None:
        """Publish the thing as known from its directory."""
        self._devices.put(self._device, "the directory lists it", confirmed=False)


LIST_AGAIN: Final = 3600.0
"""Seconds between readings of the list if the directory reports changes."""

AFTER_A_LOSS: Final = 30.0
"""Seconds after which the list is read again after a change could not be read."""

CONNECTED_AT_ONCE: Final = 20
"""Most concurrent connection attempts; the others wait until one has succeeded or failed."""

_TOO_MANY = "thing_directory.thing_refused"
_TURN = 20
_MAX_INVALID = 10_000
_NO_EVENTS = frozenset({204, 400, 404, 405, 406, 410, 422, 501})


class DirectorySession:
    """The work on one directory.

    Args:
        tasks: The task group of the things, which outlives the connection to the directory.
    """

    def __init__(
        self,
        settings: ThingDirectorySettings,
        devices: PublishedDevices,
        tasks: TaskGroup,
        has_listed: Callable[[], None],
    ) -> None:
        self._settings = settings
        self._devices = devices
        self._tasks = tasks
        self._has_listed = has_listed
        self._clock, self._log = devices.gateway.node.graph.clock, devices.gateway.node.log
        self._logins = read_logins(settings.credentials)
        self._guard: AddressGuard | None = AddressGuard()
        self._known: dict[str, bytes] = {}
        self._invalid: dict[str, bytes] = {}
        self._followed: dict[str, ListedThing] = {}
        self._connecting = anyio.CapacityLimiter(CONNECTED_AT_ONCE)
        self._lists_soon = anyio.Event()

    async def follow(self) -> None:
        """Read the list, and then changes, until that fails.

        Raises:
            LinkError: The directory does not answer, or the stream of events was lost.
            RefusedError: It refuses homebot.
            WireError: It breaks the rules.
        """
        guard = await guard_for(URL(self._settings.url).host)
        self._guard = guard.of_described
        async with HttpClient(guard=guard, login=login_at(URL(self._settings.url), self._logins)) as client:
            reader = DirectoryReader(self._settings.url, client)
            await self._listen(reader)
            while True:
                await self._list(reader)
                await anyio.sleep(self._settings.list_every)

    def problems(self) -> Iterable[str]:
        """Return the problems of things that need a person's help, in words."""
        return problems_of(self._followed.values())

    async def perform(self, command: Command) -> None:
        """Carry out a command; return when the thing has accepted it."""
        followed = self._followed.get(command.key)
        if followed is None:
            raise UnableError(f"{command.key[:100]} has no address of HTTP")
        await followed.perform(command)

    async def _listen(self, reader: DirectoryReader) -> None:
        """Follow the events of the directory; return if it has none."""
        is_open = False
        try:
            with ungrouped():
                async with reader.events() as stream, anyio.create_task_group() as tasks:
                    is_open = True
                    await self._list(reader)
                    tasks.start_soon(run_as, "the list of things", partial(self._list_again, reader))
                    async for event in stream:
                        await self._on_event(reader, event.kind, event.data)
        except (RefusedError, WireError) as exc:
            if is_open or (isinstance(exc, RefusedError) and exc.code not in _NO_EVENTS):
                raise
            pause = self._settings.list_every
            message = f"the directory has no events, so its list is read every {pause:g} s: {str(exc)[:200]}"
            self._log.info("thing_directory.no_events", message=message)

    async def _list_again(self, reader: DirectoryReader) -> None:
        while True:
            with anyio.move_on_after(LIST_AGAIN):
                await self._lists_soon.wait()
                await anyio.sleep(AFTER_A_LOSS)
            self._lists_soon = anyio.Event()
            await self._list(reader)

    async def _list(self, reader: DirectoryReader) -> None:
        listed: set[str] = set()
        is_whole, number = True, 0
        async for page in reader.pages():
            for document in page:
                number += 1
                if number % _TURN == 0:
                    await anyio.lowlevel.checkpoint()
                listed.add(self._list_thing(document))
            if len(listed) > 2 * self._settings.max_devices:
                is_whole = False  # the rest would be refused too
                break
        if is_whole:
            for key in self._known.keys() - listed:
                self._remove(key, "the directory lists it no longer")
        self._has_listed()

    async def _on_event(self, reader: DirectoryReader, kind: str, data: str) -> None:
        try:
            event = read_event(kind, data)
        except WireError as exc:
            self._devices.reject(self._settings.url, data.encode(errors="replace"), str(exc))
            return
        if event is not None:
            if event.change == "thing_deleted":
                self._remove(event.id, "it was deleted from the directory")
                return
            if not self._devices.admits(event.id):
                self._lists_soon.set()
                return
            body = await reader.retrieve(event.id)
            if body is None:
                self._remove(event.id, "it was deleted from the directory")
                return
            try:
                self._list_thing(parse_json(body))
            except WireError as exc:
                self._devices.reject(event.id, body, str(exc))

    def _list_thing(self, document: object) -> str:
        """List a thing, unless its description is unchanged; return its key, empty for none."""
        if is_longer_than(document, MAX_ANNOUNCEMENT_BYTES):
            problem = f"the description of a thing has more than {MAX_ANNOUNCEMENT_BYTES} characters"
            self._devices.reject(self._settings.url, b"", problem)
            return ""
        text = text_of(document)
        try:
            key = id_of(document)
        except WireError as exc:
            self._devices.reject(self._settings.url, text, str(exc))
            return ""
        digest = blake2b(text, digest_size=16).digest()
        if digest in {self._known.get(key), self._invalid.get(key)}:
            return key
        if not self._devices.admits(key):
            self._lists_soon.set()
            return key
        try:
            thing = read_thing(document, f"{self._settings.url}/")
        except WireError as exc:
            self._devices.reject(key, text, f"{key[:100]}: {exc}")
            if len(self._invalid) >= _MAX_INVALID:
                self._invalid.clear()
            self._invalid[key] = digest  # charged once, not for each list
            return key
        self._invalid.pop(key, None)
        self._put(
            thing,
            replace(describe_thing(thing, key, HTTP_BINDING), stale_after=lifetime_of(document, self._clock.now())),
            digest,
        )
        return key

    def _put(self, thing: Thing, device: GatewayDevice, digest: bytes) -> None:
        if device.key not in self._known and len(self._known) >= self._settings.max_devices:
            self._devices.counters.devices_refused += 1
            problem = f"more than {self._settings.max_devices} things; {device.key[:100]} is left out"
            self._devices.engine.quarantine.log_limited(_TOO_MANY, problem, source="")
            return
        self._known[device.key] = digest
        self._stop(device.key)
        schemes = {form.scheme for affordance in thing.affordances for form in affordance.forms}
        if schemes.isdisjoint(HTTP_BINDING.schemes):
            named = ", ".join(sorted(scheme for scheme in schemes if scheme))[:60]
            problem = f"its addresses are of {named}, not of HTTP" if named else "it has no address"
            if any(scheme.startswith("coap") for scheme in schemes):
                problem += "; the gateway coap can use it, given its address or its directory"
            facts = {**device.metadata, "unusable": problem}
            self._devices.put(replace(device, metadata=facts), "the directory lists it", confirmed=False)
            return
        followed = ListedThing(
            thing,
            device,
            HttpThingPort(thing, self._logins, self._guard),
            self._devices,
            poll_every=self._settings.poll_every,
            connecting=self._connecting,
        )
        self._followed[device.key] = followed
        self._tasks.start_soon(run_as, "a thing", followed.run)

    def _remove(self, key: str, why: str) -> None:
        self._known.pop(key, None)
        self._stop(key)
        self._devices.remove(key, why)

    def _stop(self, key: str) -> None:
        followed = self._followed.pop(key, None)
        if followed is not None:
            followed.stop()
