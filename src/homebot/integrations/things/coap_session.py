"""The devices of one endpoint: described, run over CoAP, and tried again when they cannot be reached.

Source: W3C Working Group Note (draft) "Web of Things (WoT) CoAP Binding": default methods, ``cov:method``,
``cov:observe``.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator, Awaitable, Callable, Mapping
from contextlib import aclosing
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

import anyio

from homebot.conventions.coap.endpoint import SCHEMES, authority_of
from homebot.conventions.coap.link_format import LINK_FORMAT, WebLink, parse_links
from homebot.conventions.payload import parse_object
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, PeerError, RefusedError, UnableError, WireError
from homebot.gateways.announced.device_runner import DriverHost
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.coap.session import EndpointSession
from homebot.integrations.things.formats.binding import RequestBinding
from homebot.integrations.things.formats.content_formats import (
    TD_FORMAT,
    coap_formats,
    content_format_of,
    content_type_of,
)
from homebot.integrations.things.formats.parse import read_thing
from homebot.integrations.things.formats.resource_types import thing_of_links
from homebot.integrations.things.formats.thing import Form, Thing, change_forms
from homebot.integrations.things.http.thing_device import ThingDevice, ThingPayload, describe_thing
from homebot.support.addresses import resolve_uri
from homebot.support.isolation import run_as, ungrouped

if TYPE_CHECKING:
    from homebot.gateways.coap.aiocoap_client import CoapAnswer, CoapClient

COAP_BINDING: Final = RequestBinding(SCHEMES, ("cov:observe", "coap:observe", ""), coap_formats)

NOT_ALLOWED: Final = 0x85
NOT_ACCEPTABLE: Final = 0x86
_OTHER = {"PUT": "POST", "POST": "PUT"}


class CoapPort:
    """The way to one thing; see :class:`homebot.integrations.things.http.thing_device.ThingPort`.

    Args:
        admits: Returns whether a notification of the thing is to be read.
    """

    binding = COAP_BINDING

    def __init__(self, client: CoapClient, admits: Callable[[], bool]) -> None:
        self._client = client
        self._admits = admits

    async def read(self, form: Form) -> ThingPayload:
        """Return the value of a resource, in the declared format if it has that."""
        method = form.method or "GET"
        try:
            accepted = content_format_of(form.response_type or form.content_type)
            answer = await self._client.request(method, form.href, accept=accepted)
        except RefusedError as exc:
            if exc.code != NOT_ACCEPTABLE:
                raise
            answer = await self._client.request(method, form.href)
        return _payload(answer)

    async def write(self, form: Form, payload: bytes) -> None:
        """Send *payload*; a property that takes no PUT is written by POST, and the other way round."""
        method = form.method or ("PUT" if "writeproperty" in form.ops else "POST")
        content_format = content_format_of(form.content_type) if payload else None
        try:
            await self._client.request(method, form.href, payload, content_format=content_format)
        except RefusedError as exc:
            if exc.code != NOT_ALLOWED or method not in _OTHER or "writeproperty" not in form.ops:
                raise
            await self._client.request(_OTHER[method], form.href, payload, content_format=content_format)

    async def observe(
        self, form: Form, read_current: Callable[[], Awaitable[None]]
    ) -> AsyncGenerator[ThingPayload, None]:
        """Yield the states of a resource, beginning with the current one."""
        del read_current
        async with aclosing(self._client.observe(form.href)) as answers:
            async for answer in answers:
                if self._admits():
                    yield _payload(answer)


def _payload(answer: CoapAnswer) -> ThingPayload:
    return ThingPayload(answer.payload, content_type_of(answer.content_format))


MAX_THINGS = 16
"""Descriptions of one endpoint that are read."""

_CORE = "/.well-known/core"
_WOT = "/.well-known/wot"
_NOT_FOUND = 0x84
_MISSES = 3


class ThingEndpointSession(EndpointSession):
    """Describes the devices of one endpoint by Thing Descriptions, or by the types of its resources."""

    _things: Mapping[str, ThingDevice] = MappingProxyType({})

    async def perform(self, command: Command) -> None:
        """Carry out a command to one of its devices."""
        thing = self._things.get(command.key)
        if thing is None:
            raise UnableError(f"{command.key[:100]} has not described itself yet")
        await thing.perform(command)

    async def run_devices(self) -> None:
        """Describe the devices and run them."""
        async with self.of_host, self._describing:
            guard = await self.guard()
            self._client = self._client.guarded_by(guard)
            described = await self._describe()
            self._client = self._client.guarded_by(guard.of_described)
        things: dict[str, ThingDevice] = {}
        for device, thing in described:
            host = DriverHost(self._devices, device.key)
            port = CoapPort(self._client, partial(self._devices.admits, device.key))
            things[device.key] = ThingDevice(thing, device, port, host, self._poll_every)
        self._things = things
        self.on_described(*self._things)
        with ungrouped():
            async with anyio.create_task_group() as tasks:
                for used in things.values():
                    tasks.start_soon(run_as, "a CoAP device", used.run)
                if not any(device.parts for device, _ in described):
                    tasks.start_soon(run_as, "the check of a CoAP device", partial(self._check, described[0][0]))

    async def _check(self, device: GatewayDevice) -> None:
        """Check periodically that a device without readable values is still there."""
        misses = 0
        self._devices.report_reachable(device.key, reachable=True)
        while True:
            await anyio.sleep(self._poll_every)
            try:
                await self._client.request("GET", self.endpoint.base + _CORE, accept=LINK_FORMAT)
            except LinkError:
                misses += 1
                if misses >= _MISSES:
                    raise
                continue
            except PeerError:
                pass  # an answer is an answer
            misses = 0
            self._devices.put(device, "it answered")

    async def _describe(self) -> list[tuple[GatewayDevice, Thing]]:
        """Return the devices of the endpoint, at least one, each with its description."""
        endpoint = self.endpoint
        if endpoint.description:
            return [self._described(await self._read_description(endpoint.description), endpoint.key)]
        links: tuple[WebLink, ...] = ()
        try:
            answer = await self._client.request("GET", endpoint.base + _CORE, accept=LINK_FORMAT)
            links = parse_links(answer.payload)
        except RefusedError as exc:
            if exc.code != _NOT_FOUND:
                raise
        devices: list[tuple[GatewayDevice, Thing]] = []
        named = [link for link in links if str(TD_FORMAT) in link.words("ct") or "wot.thing" in link.words("rt")]
        for uri in list(dict.fromkeys(uri for link in named if (uri := self._resolve(link))))[:MAX_THINGS]:
            key = endpoint.key if not devices else f"{endpoint.key}{uri.removeprefix(endpoint.base)}"
            devices.append(self._described(await self._read_description(uri), key))
        if devices:
            return devices
        try:
            return [self._described(await self._read_description(endpoint.base + _WOT), endpoint.key)]
        except (RefusedError, WireError):
            pass  # most have none
        own = {link.target: self._resolve(link) for link in links}
        thing = thing_of_links(links, own, endpoint.name or endpoint.base.partition("://")[2])
        return [self._described(thing, endpoint.key, links)]

    def _resolve(self, link: WebLink) -> str:
        """Return the address of a link; empty for one of another host, which this one does not speak for."""
        try:
            uri = resolve_uri(self.endpoint.base + "/", link.target)
            return uri if authority_of(uri) == self.authority else ""
        except ValueError:
            return ""

    async def _read_description(self, uri: str) -> Thing:
        answer = await self._client.request("GET", uri, accept=TD_FORMAT)
        thing = read_thing(parse_object(answer.payload), uri)
        return thing if self.endpoint.is_static else with_own_forms(thing, self.endpoint.base)

    def _described(self, thing: Thing, key: str, links: tuple[WebLink, ...] = ()) -> tuple[GatewayDevice, Thing]:
        endpoint = self.endpoint
        kinds = " ".join(dict.fromkeys(word for link in links for word in link.words("rt")))
        device = describe_thing(thing, key, COAP_BINDING)
        facts = {"address": endpoint.base, **endpoint.facts, **device.metadata}
        if kinds:
            facts["resource_types"] = kinds[:200]
        return (
            replace(
                device,
                metadata=facts,
                identifiers=tuple(dict.fromkeys((*device.identifiers, *endpoint.identifiers))),
                raw_address=endpoint.base if key == endpoint.key else key,
                stale_after=max(endpoint.lifetime, _MISSES * self._poll_every),
            ),
            thing,
        )


def with_own_forms(thing: Thing, base: str) -> Thing:
    """Return *thing* with those forms alone that are at the endpoint *base*: it does not speak for other hosts."""
    own = authority_of(base)
    return change_forms(thing, lambda form: form if _is_at(form.href, own) else None)


def _is_at(href: str, own: str) -> bool:
    try:
        return authority_of(href) == own
    except ValueError:
        return False
