"""One connection to one thing over HTTP.

The description is read again periodically: it may have changed, and this is how a vanished thing that pushes its values
is noticed. Any host on the network may serve a description, so only forms that lead to its own host are used.

Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, sections 6.3 and 7.1.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal

import anyio
from yarl import URL

from homebot.conventions.payload import MAX_ANNOUNCEMENT_BYTES, clean_text, parse_json
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, WireError
from homebot.gateways.address_guard import AddressGuard
from homebot.gateways.announced.device_runner import DriverHost
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

_ACCEPTED = "application/td+json, application/json;q=0.9"


@dataclass(frozen=True, slots=True)
class _ReadDescription:
    url: str
    data: bytes


class ThingSession:
    """One connection to one thing."""

    def __init__(
        self, service: FoundService, host: DriverHost, logins: Sequence[ThingLogin], poll_every: float
    ) -> None:
        self._service = service
        self._poll_every = poll_every
        self._host = host
        # a neighbour may claim localhost, an address, or a name of the internet, and its own addresses for them
        name = service.host.lower().removesuffix(".")
        self._host_name = name if name.endswith(".local") else ""
        self._guard = AddressGuard(service.addresses)
        self._own_hosts = frozenset(host.lower() for host in (self._host_name, *service.addresses) if host)
        self._logins = tuple(self._known_as(login) for login in logins)
        self._device: ThingDevice | None = None

    async def run(self) -> None:
        """Read the description and use the thing until cancelled."""
        description = await self._find()
        while True:
            description = await self._follow(description)

    async def perform(self, command: Command) -> None:
        """Carry out a command; return when the thing has accepted it."""
        if self._device is None:
            raise LinkError(f"{self._service.name} is not connected")
        await self._device.perform(command)

    async def _follow(self, description: _ReadDescription) -> _ReadDescription:
        """Use the thing until its description changes, and return the new one."""
        thing = self._usable(read_thing(parse_json(description.data), description.url))
        device = describe_thing(thing, self._service.key, HTTP_BINDING)
        if self._service.properties.get("type") == "Directory" or "ThingDirectory" in thing.types:
            place = str(URL(description.url).origin())
            metadata = {**device.metadata, "thing_directory": clean_text(place)}
            self._host.describe(replace(device, parts=(), metadata=metadata))
            return await self._until_changed(description)
        changed = description
        try:
            with ungrouped():
                async with HttpThingPort(thing, self._logins, self._guard) as port, anyio.create_task_group() as tasks:
                    self._device = ThingDevice(thing, device, port, self._host, self._poll_every)
                    tasks.start_soon(run_as, "a thing", self._device.run)
                    changed = await self._until_changed(description)
                    tasks.cancel_scope.cancel()
        finally:
            self._device = None
        return changed

    async def _until_changed(self, description: _ReadDescription) -> _ReadDescription:
        while True:
            await anyio.sleep(READ_AGAIN)
            now = await self._read(description.url)
            if now != description:
                return now

    async def _find(self) -> _ReadDescription:
        """Return the description from the first address that answers."""
        announced = self._service.properties
        scheme: Literal["http", "https"] = "https" if announced.get("scheme") == "https" else "http"
        path = announced.get("td", "") or WELL_KNOWN
        path = path if path.startswith("/") else f"/{path}"
        name = (self._host_name,) if scheme == "https" and self._host_name else ()

        async def read_at(address: str) -> _ReadDescription:
            return await self._read(http_origin(address, self._service.port, scheme) + path)

        return await first_answer(self._service.name, (*name, *self._service.addresses), read_at)

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
