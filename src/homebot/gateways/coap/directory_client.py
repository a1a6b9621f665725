"""Endpoints that an external resource directory lists: looked up, and followed.

The lookup is observed, so that changes come by themselves, and read now and then as well: a notification may be lost.

Source: RFC 9176, sections 4.3 (finding the lookup) and 6.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import aclosing
from dataclasses import replace
from functools import partial
from random import Random
from typing import TYPE_CHECKING, Final
from urllib.parse import urlsplit

import anyio

from homebot.clock import Clock
from homebot.conventions.coap.endpoint import CoapEndpoint, authority_of, endpoint_of_link
from homebot.conventions.coap.link_format import LINK_FORMAT, parse_links
from homebot.errors import LinkError, PeerError, RefusedError, WireError
from homebot.gateways.address_guard import guard_for
from homebot.support.addresses import resolve_uri
from homebot.support.backoff import Backoff, BackoffCounter
from homebot.support.isolation import run_as, ungrouped

if TYPE_CHECKING:
    from homebot.gateways.coap.aiocoap_client import CoapClient

RETRY: Final = Backoff(first=1.0, factor=2.0, cap=5.0, late_cap=30.0, late_after=300.0, jitter=0.5)

CHECK_EVERY = 20.0
"""Seconds after which the lookup is read although nothing came."""

_LOOKUP = "core.rd-lookup-ep"


class DirectoryClient:
    """The client of one resource directory.

    Args:
        on_listed: Gets all endpoints that it lists, whenever that may have changed.
        reject: Receives invalid payloads: the bytes and the reason.
        report: Receives the state of the directory: empty if it answers, else the problem.
    """

    def __init__(
        self,
        uri: str,
        client: CoapClient,
        clock: Clock,
        random: Random,
        *,
        on_listed: Callable[[tuple[CoapEndpoint, ...]], None],
        reject: Callable[[bytes, str], None],
        report: Callable[[str], None],
    ) -> None:
        self._uri = uri.rstrip("/")
        self._client = client
        self._clock = clock
        self._random = random
        self._on_listed = on_listed
        self._reject = reject
        self._report = report
        self._is_here = False

    async def run(self) -> None:
        """Follow the directory until cancelled."""
        retries = BackoffCounter(self._clock, self._random, CHECK_EVERY)
        while True:
            retries.begin()
            try:
                await self._follow()
            except (LinkError, PeerError) as exc:
                if isinstance(exc, WireError):
                    self._reject(exc.frame, str(exc))
                self._report(f"the resource directory {self._uri} cannot be read: {exc}")
            await anyio.sleep(retries.fail(RETRY))

    async def _follow(self) -> None:
        guard = await guard_for(urlsplit(self._uri).hostname)
        self._is_here = guard.of_described is None
        self._client = self._client.guarded_by(guard)
        lookup = await self._find_lookup()
        await self._read(lookup)
        with ungrouped():
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(run_as, "the lookup of a resource directory", partial(self._observe, lookup))
                while True:
                    await anyio.sleep(CHECK_EVERY)
                    await self._read(lookup)

    async def _find_lookup(self) -> str:
        answer = await self._client.request("GET", f"{self._uri}/.well-known/core?rt=core.rd*", accept=LINK_FORMAT)
        for link in parse_links(answer.payload):
            if _LOOKUP in link.words("rt"):
                try:
                    uri = resolve_uri(f"{self._uri}/", link.target)
                    is_own = authority_of(uri) == authority_of(self._uri)
                except ValueError:
                    is_own, uri = False, ""
                if is_own:
                    return uri
        raise RefusedError(f"looking endpoints up at {self._uri}", f"it offers no {_LOOKUP}")

    async def _read(self, lookup: str) -> None:
        self._read_list((await self._client.request("GET", lookup, accept=LINK_FORMAT)).payload)

    async def _observe(self, lookup: str) -> None:
        try:
            async with aclosing(self._client.observe(lookup, LINK_FORMAT)) as answers:
                async for answer in answers:
                    self._read_list(answer.payload)
        except RefusedError:
            return  # it is read often enough

    def _read_list(self, payload: bytes) -> None:
        """Report the endpoints in a list; an invalid list changes nothing."""
        links = parse_links(payload)
        self._report("")
        endpoints: dict[str, CoapEndpoint] = {}
        for link in links:
            try:
                endpoint = replace(endpoint_of_link(link), source=self._uri, is_foreign=not self._is_here)
            except WireError as exc:
                self._reject(payload[:100], str(exc))
                continue
            endpoints.setdefault(endpoint.key, endpoint)
        self._on_listed(tuple(endpoints.values()))
