"""The gateway for CoAP."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import anyio
from anyio.abc import TaskGroup, TaskStatus
from pydantic import BaseModel

from homebot.conventions.coap.endpoint import (
    CoapEndpoint,
    authority_of,
    endpoint_at,
    host_of,
    static_endpoint,
)
from homebot.conventions.coap.link_format import parse_links
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, UnableError, UsageError, WireError
from homebot.gateways.announced.device_runner import problems_of
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import Gateway, GatewayContext
from homebot.gateways.coap.directory_client import DirectoryClient
from homebot.gateways.coap.session import EndpointSession
from homebot.gateways.coap.settings import CoapGatewaySettings
from homebot.graph import Node
from homebot.plugins import check_extra, has_plugin, load_plugin
from homebot.support.backoff import DEVICE_BACKOFF, BackoffCounter
from homebot.support.isolation import run_as

if TYPE_CHECKING:
    from homebot.gateways.coap.aiocoap_client import CoapClient, GroupAnswer

DESCRIBED_AT_ONCE, DESCRIBED_PER_HOST = 8, 2
"""Endpoints that are described at the same time, and of those at one address; the others wait."""

MAX_PER_HOST = 32
"""Endpoints at one address that are found by multicast: a host that answers from many ports is one host."""

SESSIONS, SESSION = "homebot.coap_sessions", "thing"
"""Entry-point group of integrations that describe the device at an endpoint, and the name there."""

_TOO_MANY = "coap.endpoint_refused"


class CoapGateway(Gateway):
    """A gateway to devices that are CoAP servers."""

    Settings: ClassVar[type[BaseModel]] = CoapGatewaySettings

    def __init__(self, node: Node, settings: CoapGatewaySettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._settings = settings
        self.devices = PublishedDevices(
            self,
            self._perform,
            settings,
            max_devices=settings.max_devices,
            find_problems=lambda: problems_of(self._sessions.values()),
        )
        self._describing = anyio.CapacityLimiter(DESCRIBED_AT_ONCE)
        self._sessions: dict[str, EndpointSession] = {}
        self._session_of: type[EndpointSession] = load_plugin(SESSIONS, SESSION)
        self._ways: dict[str, str | None] = {}  # the problem of each; None before the first attempt
        self._all_tried = anyio.Event()
        self._client: CoapClient | None = None
        self._tasks: TaskGroup | None = None

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Look for the libraries, for a way to find devices, and for an integration that describes them."""
        check_extra('the gateway "coap"', "coap", "aiocoap", "cbor2", "filelock")
        assert isinstance(settings, CoapGatewaySettings)  # noqa: S101 - given by the runtime
        for credential in settings.credentials:
            for name in ("settings.json", "secret.json") if credential.oscore else ():
                if not (Path(credential.oscore) / name).is_file():
                    raise UsageError(
                        f"credentials for {credential.uri}: {credential.oscore} has no {name} of an OSCORE context"
                    )
            if credential.identity:
                check_extra(f"the DTLS key for {credential.uri}", "coap,dtls", "DTLSSocket")
        if not (settings.devices or settings.resource_directory or settings.interfaces):
            raise UsageError("the gateway finds no device: set devices, resource_directory or interfaces")
        if not has_plugin(SESSIONS, SESSION):
            raise UsageError(
                "no integration that describes CoAP devices is installed; install one or remove the gateway"
            )

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Find devices, and work with them, until cancelled."""
        from homebot.gateways.coap.aiocoap_client import CoapClient  # noqa: PLC0415 - a library of an extra

        retries = BackoffCounter(self.node.graph.clock, self.random)
        while True:
            try:
                async with CoapClient.open(self._settings.timeout, self._settings.credentials) as client:
                    retries.succeed()
                    await self._serve(client, task_status)
            except LinkError as exc:
                self.publish_state("unavailable", str(exc))
                self._all_tried.set()
                self.mark_ready(task_status)
                await self.devices.on_link_loss()
                await anyio.sleep(retries.fail(DEVICE_BACKOFF))

    async def _serve(self, client: CoapClient, task_status: TaskStatus[None]) -> None:
        settings = self._settings
        self._client = client
        async with anyio.create_task_group() as tasks:
            self._tasks = tasks
            ways = {uri: self._directory_client(uri, client).run for uri in settings.resource_directory}
            for interface in settings.interfaces:
                for version in settings.groups:
                    ways[f"{interface} {version}"] = partial(self._ask, client, interface, version)
            self._ways = dict.fromkeys(ways)
            for way, run in ways.items():
                tasks.start_soon(run_as, way, run)
            for uri in settings.devices:
                self._on_found(static_endpoint(uri))
            self._report_ways()
            if not self._all_tried.is_set():
                if self._ways:
                    await self._all_tried.wait()
                self._all_tried.set()
                self._report_ways()
                self.mark_ready(task_status)
            await anyio.sleep_forever()

    def _report(self, way: str, problem: str) -> None:
        """Record the problem of one way to find devices; empty for none."""
        if problem and self._ways.get(way) != problem:
            self.node.log.warning("coap.way_lost", message=f"{way} finds no devices: {problem[:200]}", way=way)
        self._ways[way] = problem
        if None not in self._ways.values():
            self._all_tried.set()
        self._report_ways()

    def _report_ways(self) -> None:
        """Publish the state: unavailable if no way to find devices is left, and no device has a fixed address."""
        problems = tuple(way for way in self._ways.values() if way)
        self.devices.problems = problems
        if not self._all_tried.is_set() and self._ways:
            return
        if problems and len(problems) == len(self._ways) and not self._settings.devices:
            self.publish_state("unavailable", "; ".join(problems)[:500])
        else:
            self.publish_state("active")

    def _directory_client(self, uri: str, client: CoapClient) -> DirectoryClient:
        return DirectoryClient(
            uri,
            client,
            self.node.graph.clock,
            self.random,
            on_listed=partial(self._on_registered_list, uri),
            reject=partial(self.devices.reject, uri),
            report=partial(self._report, uri),
        )

    def _on_registered_list(self, directory: str, endpoints: tuple[CoapEndpoint, ...]) -> None:
        """Update the endpoints of a directory from its whole list; missing ones are no longer registered there."""
        listed = {endpoint.key for endpoint in endpoints}
        for endpoint in [session.endpoint for session in self._sessions.values()]:
            if endpoint.source == directory and endpoint.key not in listed:
                self._on_gone(endpoint, f"its registration at {directory} ended")
        for endpoint in endpoints:
            self._on_found(endpoint)

    async def _ask(self, client: CoapClient, interface: str, version: str) -> None:
        way = f"{interface} {version}"
        while True:
            try:
                await client.ask_group(version, interface, self._settings.group_port, self._on_answer)
                self._report(way, "")
            except LinkError as exc:
                self._report(way, str(exc))
            await anyio.sleep(self._settings.ask_every)

    def _on_answer(self, answer: GroupAnswer) -> None:
        """Handle an answer to a multicast question; it may be incomplete, as its sender is asked again."""
        source = answer.host.partition("%")[0]
        if not self.devices.admits(source):
            return
        if answer.is_whole:
            try:
                parse_links(answer.payload)
            except WireError as exc:
                self.devices.reject(source, answer.payload, str(exc))
                return
        endpoint = endpoint_at(answer.host, answer.port)
        found_there = sum(not session.endpoint.is_registered for session in self._at_host_of(endpoint))
        if endpoint.key not in self._sessions and found_there >= MAX_PER_HOST:
            self.devices.reject(source, b"", f"more than {MAX_PER_HOST} endpoints answer from there")
            return
        self._on_found(endpoint)

    def _at_host_of(self, endpoint: CoapEndpoint) -> list[EndpointSession]:
        host = host_of(endpoint.base)
        return [session for session in self._sessions.values() if session.host == host]

    def _on_found(self, endpoint: CoapEndpoint) -> None:
        """Start the session of an endpoint, or wake the one that it has."""
        known = self._sessions.get(endpoint.key)
        if known is not None and (known.endpoint == endpoint or known.endpoint.source != endpoint.source):
            if not endpoint.is_registered:  # a directory also lists silent ones
                known.wake()
            return
        if known is not None:  # it moved, or says other things of itself
            self._forget(known)
        elif not self._may_begin(endpoint):
            return
        assert self._client is not None  # noqa: S101 - found while it serves
        assert self._tasks is not None  # noqa: S101 - likewise
        of_host = next(
            (session.of_host for session in self._at_host_of(endpoint)), anyio.CapacityLimiter(DESCRIBED_PER_HOST)
        )
        describing, poll_every = (of_host, self._describing), self._settings.poll_every
        session = self._session_of(endpoint, self._client, self.devices, poll_every=poll_every, describing=describing)
        self._sessions[endpoint.key] = session
        self._tasks.start_soon(run_as, "a CoAP endpoint", partial(self._run, session))

    def _may_begin(self, endpoint: CoapEndpoint) -> bool:
        """Return whether a new endpoint is worked with.

        Each address is once. The configuration comes first, then a registered name, then an address that answered.
        """
        at = authority_of(endpoint.base)
        same = [session.endpoint for session in self._sessions.values() if session.authority == at]
        if any(other.is_static for other in same) or (same and not endpoint.is_registered):
            return False
        for other in same:
            if not other.is_registered:
                self._on_gone(other, f"it registered itself as {endpoint.key}")
        if len(self._sessions) < self._settings.max_devices:
            return True
        self.devices.counters.devices_refused += 1
        problem = f"more than {self._settings.max_devices} endpoints; the new one is left out: {endpoint.key[:100]}"
        self.devices.engine.quarantine.log_limited(_TOO_MANY, problem, source="")
        return False

    def _forget(self, session: EndpointSession) -> None:
        if self._sessions.get(session.key) is session:
            session.stop()
            del self._sessions[session.key]

    async def _run(self, session: EndpointSession) -> None:
        await session.run()
        self._forget(session)

    def _on_gone(self, endpoint: CoapEndpoint, why: str) -> None:
        known = self._sessions.get(endpoint.key)
        if known is None or known.endpoint.source != endpoint.source:
            return
        self._forget(known)
        for key in known.keys:
            self.devices.remove(key, why)

    async def _perform(self, command: Command) -> None:
        for session in self._sessions.values():
            if command.key in session.keys:
                await session.perform(command)
                return
        raise UnableError(f"{command.key[:100]} is not known at any endpoint")
