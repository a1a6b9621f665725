"""One connection to one thing over HTTP.

The description is read again periodically: it may have changed, and this is how a vanished thing that pushes its values
is noticed. Any host on the network may serve a description, so only forms that lead to its own host are used.

Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, sections 6.2, 6.3 and 7.1.
"""

from collections.abc import Sequence
from contextlib import AsyncExitStack
from dataclasses import dataclass, replace
from typing import Final, Literal

import anyio
from yarl import URL

from homebot.conventions.payload import MAX_ANNOUNCEMENT_BYTES, clean_text, parse_json
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.address_guard import AddressGuard
from homebot.gateways.announced.device_runner import DriverHost
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.drivers.base import FoundService, first_answer
from homebot.gateways.http_address import http_origin, parse_url, shown_url
from homebot.gateways.http_client import HttpClient
from homebot.gateways.password_settings import ThingLogin
from homebot.integrations.things.formats.parse import read_thing
from homebot.integrations.things.formats.thing import Form, Thing, change_forms
from homebot.integrations.things.http.http_port import HTTP_BINDING, HttpThingPort, login_at
from homebot.integrations.things.http.thing_device import ThingDevice, describe_thing
from homebot.support.isolation import run_as, ungrouped

WELL_KNOWN: Final = "/.well-known/wot"
READ_AGAIN: Final = 18.0
"""Seconds between two readings of the description. With the time limit of a request, a vanished thing is noticed within
half a minute."""

MAX_THINGS: Final = 16
"""The things of one server that are used: the first ones."""

_ACCEPTED = "application/td+json, application/json;q=0.9"
_NOT_THERE = frozenset({404, 405, 410})


@dataclass(frozen=True, slots=True)
class _ReadDescription:
    url: str
    data: bytes


class ThingSession:
    """One connection to one thing."""

    def __init__(
        self,
        service: FoundService,
        host: DriverHost,
        logins: Sequence[ThingLogin],
        poll_every: float,
        *,
        must_describe: bool,
        is_web_thing: bool,
    ) -> None:
        self._service = service
        self._poll_every = poll_every
        self._host = host
        self._must_describe = must_describe
        self._is_web_thing = is_web_thing
        # a neighbour may claim localhost, an address, or a name of the internet, and its own addresses for them
        name = service.host.lower().removesuffix(".")
        self._host_name = name if name.endswith(".local") else ""
        self._guard = AddressGuard(service.addresses)
        self._own_hosts = frozenset(host.lower() for host in (self._host_name, *service.addresses) if host)
        self._logins = tuple(self._known_as(login) for login in logins)
        self._devices: dict[str, ThingDevice] = {}

    async def run(self) -> None:
        """Read the description and use the thing until cancelled."""
        description = await self._find()
        while description is not None:
            description = await self._follow(description)
        self._host.describe(GatewayDevice(self._service.key, self._service.name))
        await anyio.sleep_forever()

    async def perform(self, command: Command) -> None:
        """Carry out a command; return when the thing has accepted it."""
        device = self._devices.get(command.key)
        if device is None:
            raise LinkError(f"{self._service.name} is not connected")
        await device.perform(command)

    async def _follow(self, description: _ReadDescription) -> _ReadDescription:
        """Use the thing until its description changes, and return the new one."""
        described, key = parse_json(description.data), self._service.key
        listed = {key: described}
        if isinstance(described, list) and len(described) != 1:  # Web Things, each a device behind that of the service
            listed = {f"{key}/{number}": document for number, document in enumerate(described[:MAX_THINGS])}
        usable = {key: self._usable(read_thing(document, description.url)) for key, document in listed.items()}
        things = [(thing, describe_thing(thing, key, HTTP_BINDING)) for key, thing in usable.items()]
        own = next((thing for thing in things if thing[1].key == self._service.key), None)
        if own is None:
            self._host.describe(GatewayDevice(self._service.key, self._service.name))
        elif self._service.properties.get("type") == "Directory" or "ThingDirectory" in own[0].types:
            place = str(URL(description.url).origin())
            metadata = {**own[1].metadata, "thing_directory": clean_text(place)}
            self._host.describe(replace(own[1], parts=(), metadata=metadata))
            return await self._until_changed(description)
        self._host.describe_behind([] if own else [device for _, device in things])
        changed = description
        try:
            with ungrouped():
                async with AsyncExitStack() as ports, anyio.create_task_group() as tasks:
                    for thing, device in things:
                        port = await ports.enter_async_context(HttpThingPort(thing, self._logins, self._guard))
                        used = ThingDevice(thing, device, port, self._host, self._poll_every, is_behind=not own)
                        self._devices[device.key] = used
                        tasks.start_soon(run_as, "a thing", used.run)
                    changed = await self._until_changed(description)
                    tasks.cancel_scope.cancel()
        finally:
            self._devices.clear()
        return changed

    async def _until_changed(self, description: _ReadDescription) -> _ReadDescription:
        while True:
            await anyio.sleep(READ_AGAIN)
            now = await self._read(description.url)
            if now != description:
                return now

    async def _find(self) -> _ReadDescription | None:
        """Return the description from the first address that answers; None if there is none and none is required."""
        announced, is_encrypted, path = self._service.properties, False, WELL_KNOWN
        if self._must_describe and self._is_web_thing:
            is_encrypted, path = announced.get("tls") == "1", announced.get("path", "") or "/"
        elif self._must_describe:
            is_encrypted, path = announced.get("scheme") == "https", announced.get("td", "") or WELL_KNOWN
        scheme: Literal["http", "https"] = "https" if is_encrypted else "http"
        path = path if path.startswith("/") else f"/{path}"
        name = (self._host_name,) if is_encrypted and self._host_name else ()

        async def read_at(address: str) -> _ReadDescription:
            return await self._read(http_origin(address, self._service.port, scheme) + path)

        try:
            return await first_answer(self._service.name, (*name, *self._service.addresses), read_at)
        except RefusedError as exc:
            if self._must_describe or exc.code not in _NOT_THERE:
                raise
        except WireError:
            if self._must_describe:
                raise
        return None

    async def _read(self, url: str) -> _ReadDescription:
        login = login_at(parse_url(url), self._logins)
        async with HttpClient(guard=self._guard, login=login, max_bytes=MAX_ANNOUNCEMENT_BYTES) as client:
            answer = await client.get(url, accept=_ACCEPTED)
        if "json" not in answer.content_type and answer.content_type:
            raise WireError(f"{shown_url(URL(url))} has {answer.content_type[:60]!a}, no Thing Description")
        return _ReadDescription(url, answer.body)

    def _known_as(self, login: ThingLogin) -> ThingLogin:
        """Return credentials for the host name of the service extended to its addresses."""
        if not self._host_name or not login.is_for(self._host_name, self._service.port):
            return login
        shown = (f"[{address}]" if ":" in address else address for address in self._service.addresses)
        return login.with_hosts(*(f"{host}:{self._service.port}" for host in shown))

    def _usable(self, thing: Thing) -> Thing:
        """Return *thing* with only the forms that lead to its own host."""
        left_out: list[Form] = []

        def usable(form: Form) -> Form | None:
            own_form = self._at_own_host(form) if form.scheme in HTTP_BINDING.schemes else form
            if own_form is None:
                left_out.append(form)
            return own_form

        changed = change_forms(thing, usable)
        if left_out:
            message = f"{self._service.name}: {len(left_out)} forms lead to other hosts and are not used"
            self._host.log.warning("thing.forms_left_out", message=message)
        return changed

    def _at_own_host(self, form: Form) -> Form | None:
        """Return *form* with an IP address in place of a host name that this computer may not resolve."""
        try:
            where = parse_url(form.href)
        except WireError:
            return None
        name = (where.host or "").lower().removesuffix(".")
        if name not in self._own_hosts:
            return None
        if name == self._host_name and where.scheme == "http" and self._service.addresses:
            origin = URL(http_origin(self._service.addresses[0], where.port or 80))
            return replace(form, href=str(origin.join(where.relative())))
        return form
