"""The mDNS gateway: finds devices on the local network by DNS-SD, and talks to them by drivers."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, ClassVar

import anyio
import anyio.to_thread
from anyio.abc import TaskGroup, TaskStatus
from pydantic import BaseModel

from homebot.conventions.dns_sd import FoundService, facts_of, host_identifiers, identifiers_of, name_of
from homebot.conventions.ecosystem import Ecosystem, ecosystems, hint_facts
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError
from homebot.gateways.announced.device_runner import problems_of
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import Gateway, GatewayContext
from homebot.gateways.drivers.driver_runner import LOST_BACKOFF, DriverRunner, UsableDriver, find_drivers
from homebot.gateways.mdns.network import Interfaces, NetworkInterfaces, ResolvedService
from homebot.gateways.mdns.own_services import OwnServices
from homebot.gateways.mdns.services import CHANGE_EVERY, Services
from homebot.gateways.mdns.settings import MdnsGatewaySettings
from homebot.graph import Node
from homebot.plugins import check_extra
from homebot.support.backoff import BackoffCounter
from homebot.support.installation import Installation
from homebot.support.isolation import run_as, ungrouped

if TYPE_CHECKING:
    from homebot.gateways.mdns.zeroconf_network import MdnsNetwork

DRIVER_NOT_USED = "mdns.driver_not_used"

MAX_ASLEEP = 100
"""Sleeping devices that stay listed; if there are more, the one that has slept longest is removed."""

SLACK = 15.0
"""Seconds after the expiry of its SRV record in which a service is asked again before it counts as stale."""


@dataclass(eq=False, slots=True)
class _Listed:
    """A listed service, with its running driver if it has one, and the devices behind its device, by key."""

    service: FoundService
    stale_after: float
    device: GatewayDevice | None = None
    behind: dict[str, GatewayDevice] = field(default_factory=dict)
    runner: DriverRunner | None = None


class MdnsGateway(Gateway):
    """Gateway to the devices on the local network that announce themselves by DNS-SD.

    Args:
        context: Services of its host; a :class:`NetworkInterfaces` is used in place of the computer's.
    """

    Settings: ClassVar[type[BaseModel]] = MdnsGatewaySettings

    def __init__(
        self, node: Node, settings: MdnsGatewaySettings | None = None, context: GatewayContext | None = None
    ) -> None:
        settings = settings or MdnsGatewaySettings()
        super().__init__(node, settings, context)
        self._settings = settings
        self._retries = BackoffCounter(node.graph.clock, self.random)
        self._interfaces = self.context.service(NetworkInterfaces) or NetworkInterfaces()
        self._drivers: Mapping[str, UsableDriver] = {}
        self._ecosystems = {service_type: kind for kind in ecosystems() for service_type in kind.service_types}
        self._listed: dict[str, _Listed] = {}
        self._tasks: TaskGroup | None = None
        self._unavailable = "it has not started"
        self.devices = PublishedDevices(
            self,
            self._perform,
            settings,
            refresh=self._refresh,
            max_devices=settings.max_services,
            find_problems=lambda: problems_of(listed.runner for listed in self._listed.values()),
        )
        self._services = Services(self, node.graph.clock, settings.max_services)
        self._asleep: dict[str, None] = {}
        installation = self.context.service(Installation) or Installation()
        self._own = OwnServices(node, settings.announce_as, installation) if settings.announce else None

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Check that the libraries and the configured drivers are there."""
        check_extra('the gateway "mdns"', "mdns", "zeroconf", "ifaddr")
        if isinstance(settings, MdnsGatewaySettings):
            find_drivers(settings.drivers, settings.folder)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Follow the services on the network until cancelled; ready after the first attempt to listen."""
        await anyio.to_thread.run_sync(import_module, "homebot.gateways.mdns.zeroconf_network")  # starts a program
        self._drivers, problems = find_drivers(self._settings.drivers, self._settings.folder)
        self.devices.problems = problems
        for problem in problems:
            self.node.log.warning(DRIVER_NOT_USED, message=problem)
        wanted = self._settings.interfaces
        interfaces = self._interfaces.find(wanted)
        while True:
            try:
                await self._follow(interfaces, task_status)
            except LinkError as exc:
                self._unavailable = str(exc)
                self.publish_state("unavailable", str(exc))
                await self.devices.on_link_loss()
            self.mark_ready(task_status)
            with anyio.move_on_after(self._retries.fail(LOST_BACKOFF)):
                interfaces = await self._interfaces.wait_for_change(wanted, interfaces)

    def publish(self, resolved_service: ResolvedService) -> None:
        """List a service that is new, still there, or changed."""
        service = resolved_service.service
        if resolved_service.problem:
            self.devices.reject(service.key, resolved_service.txt, resolved_service.problem)
            if not service.addresses:
                return
        if self._own is not None:
            self._own.on_other_service(service)
        if self._ecosystems.get(service.service_type, Ecosystem).is_own(service):
            return
        listed = self._listed.get(service.key)
        if listed is None:
            listed = self._listed[service.key] = _Listed(service, resolved_service.ttl + SLACK)
            self._start(listed)
        else:
            listed.service = service
            if service.key in self._asleep:
                self._wake(service.key)
                self._start(listed)
            elif listed.runner is not None:
                listed.runner.change(service)
        if listed.runner is None or listed.device is not None:
            self._publish(listed, listed.device, "it is announced")

    def confirm_connected(self, name: str) -> bool:
        """Keep a service that does not answer while its driver is connected: multicast is lost more easily."""
        listed = self._listed.get(name)
        if listed is None or listed.runner is None or not listed.runner.is_connected:
            return False
        self._publish(listed, listed.device, "its driver is connected")
        return True

    def drop(self, name: str, why: str) -> None:
        """Remove a service that is gone; a sleeping device stays listed."""
        listed = self._listed.get(name)
        if listed is not None and self._sleeps(listed):
            self._stop(listed)
            self._put_to_sleep(name)
            self._publish(listed, None, "it fell asleep", confirmed=False)
            self.devices.report_reachable(name, reachable=None)
        else:
            self._remove(name, why)

    def refuse(self, name: str, why: str) -> None:
        """Count an announcement that is not followed as an offence of its sender."""
        if self.devices.admits(name):
            self.devices.reject(name, b"", f"it is not followed: {why}")

    def delay(self, name: str) -> None:
        """Count a delayed change as an offence of the service."""
        self.devices.reject(name, b"", f"its records change too often; they are read every {CHANGE_EVERY:g} s now")

    async def _follow(self, interfaces: Interfaces, task_status: TaskStatus[None]) -> None:
        """Follow the services on these *interfaces*, and on those that take their place."""
        from homebot.gateways.mdns.zeroconf_network import MdnsNetwork  # noqa: PLC0415 - an extra

        wanted = self._settings.interfaces
        _check_present(interfaces, wanted)
        opened = MdnsNetwork.opened(interfaces, self._services.on_news, self.devices.counters)
        with ungrouped():
            async with opened as network, anyio.create_task_group() as tasks:
                self._tasks = tasks
                self._begin(network, tasks)
                self.mark_ready(task_status)
                while True:
                    interfaces = await self._interfaces.wait_for_change(wanted, interfaces)
                    _check_present(interfaces, wanted)
                    await network.change_interfaces(interfaces)

    def _begin(self, network: MdnsNetwork, tasks: TaskGroup) -> None:
        known = [listed.service for listed in self._listed.values()]
        for listed in self._listed.values():
            if listed.service.key not in self._asleep:
                self._start(listed)
        tasks.start_soon(run_as, self.node.full_name, partial(self._services.follow, network, known))
        for service_type in sorted(self._settings.types_with((*self._drivers, *self._ecosystems))):
            network.browse(service_type)
        if self._own is not None:
            tasks.start_soon(run_as, self.node.full_name, partial(self._own.announce, network))
        self._unavailable = ""
        self._retries.succeed()
        self.publish_state("active")

    def _start(self, listed: _Listed) -> None:
        driver = self._drivers.get(listed.service.service_type)
        if driver is None or self._tasks is None:
            return
        listed.runner = DriverRunner(
            driver, listed.service, self.devices, partial(self._publish, listed), listed.behind
        )
        self._tasks.start_soon(run_as, self.node.full_name, listed.runner.run)

    def _stop(self, listed: _Listed | None) -> None:
        if listed is not None and listed.runner is not None:
            listed.runner.stop()
            listed.runner = None

    def _remove(self, name: str, why: str) -> None:
        self._wake(name)
        listed = self._listed.pop(name, None)
        self._stop(listed)
        for key in (name, *(listed.behind if listed is not None else ())):
            self.devices.remove(key, why)

    def _put_to_sleep(self, name: str) -> None:
        if name in self._asleep:
            return
        self._asleep[name] = None
        longest = self._settings.forget_sleeping_after
        too_long = partial(self._remove, name, f"it did not come back from sleep within {longest:g} s")
        self.devices.engine.scheduler.plan(("asleep", name), longest, too_long)
        if len(self._asleep) > MAX_ASLEEP:
            self._remove(next(iter(self._asleep)), f"more than {MAX_ASLEEP} devices are asleep")

    def _wake(self, name: str) -> None:
        self._asleep.pop(name, None)
        self.devices.engine.scheduler.drop(("asleep", name))

    def _sleeps(self, listed: _Listed) -> bool:
        known = listed.device
        return (known is not None and known.sleeps) or listed.service.name in self._settings.sleeping

    def _publish(self, listed: _Listed, device: GatewayDevice | None, why: str, *, confirmed: bool = True) -> None:
        """Publish a service with the facts of its driver and of DNS-SD; without a driver it has no parts."""
        if self._listed.get(listed.service.key) is not listed:
            return
        service = listed.service
        known_by = self._ecosystems.get(service.service_type, Ecosystem)
        name = name_of(service, known_by.name_key)
        bare = GatewayDevice(service.key, name, service_type=service.service_type.removesuffix(".local."))
        listed.device = known = device or listed.device or bare
        facts = facts_of(service) | hint_facts(known_by, service, self.context.gateways) | dict(known.metadata)
        host = host_identifiers(service) if known.parts or listed.runner is None else ()  # else it is not known yet
        identifiers = (*known.identifiers, *identifiers_of(service, known_by.declared(service)), *host)
        if self._sleeps(listed):
            facts["sleep"] = "asleep" if service.key in self._asleep else "awake"
        self.devices.put(
            replace(
                known,
                metadata=facts,
                identifiers=tuple(dict.fromkeys(identifiers)),
                stale_after=known.stale_after or self._settings.sleeping.get(service.name, listed.stale_after),
            ),
            why,
            confirmed=confirmed,
        )

    async def _perform(self, command: Command) -> Collection[str] | None:
        return await self._runner_of(command.key).perform(command)

    async def _refresh(self, key: str, part: str) -> None:
        await self._runner_of(key).refresh(key, part)

    def _runner_of(self, key: str) -> DriverRunner:
        if self._unavailable:
            raise LinkError(f"no device can be reached: {self._unavailable}")
        if key in self._asleep:
            raise LinkError(f"{key[:100]} is asleep; try again once it is awake")
        listed = self._listed.get(key)
        if listed is None:
            listed = next((entry for entry in self._listed.values() if key in entry.behind), None)
        if listed is None:
            raise LinkError(f"{key[:100]} is not on the network now")
        if listed.runner is None:
            raise LinkError(f"{key[:100]} has no driver; `homebot doctor` names those that cannot be used")
        return listed.runner


def _check_present(interfaces: Interfaces, wanted: tuple[str, ...]) -> None:
    if not interfaces:
        raise LinkError(f"there is no network interface {' or '.join(wanted)}".rstrip())
