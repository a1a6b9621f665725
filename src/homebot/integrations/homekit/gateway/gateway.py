"""The HomeKit gateway: accessories on the local network, each over its own connection.

The mDNS gateway finds the accessories; this one follows its sightings on the graph, pairs, and talks to accessories
that are paired with homebot. The keys are kept in a file; the setup codes are forgotten.
"""

from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import partial
from importlib import import_module
from itertools import islice
from typing import ClassVar, Final

import anyio
from anyio import to_thread
from anyio.abc import TaskGroup, TaskStatus
from pydantic import BaseModel

from homebot.config import SecretFile
from homebot.devices import GatewayNames, GatewayState, Sighting
from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, UnableError, WireError
from homebot.gateways.announced.device_runner import MAX_PROBLEMS, problems_of
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import Gateway, GatewayContext, GatewaySettings
from homebot.gateways.pairing import PairingFile, PairingServices, UnpairedDevice
from homebot.graph import DurabilityPolicy, Node, QoSProfile, Subscription
from homebot.integrations.homekit.formats.ecosystem import read_homekit_digits
from homebot.integrations.homekit.gateway.accessory_runner import AccessoryRunner, describe
from homebot.integrations.homekit.gateway.port import PAIRS_WITHIN, FoundAccessory, HomekitPort, Pairing
from homebot.plugins import check_extra
from homebot.support.isolation import run_as


class HomekitGatewaySettings(GatewaySettings):
    """The settings of a HomeKit gateway.

    Attributes:
        mdns: The name of the mDNS gateway, which finds the accessories.
        pairings: File with the keys of paired accessories, readable by its owner only. By default
            ``NAME.pairings.json``, with the gateway's name, beside homebot's index.
    """

    mdns: str = "mdns"
    pairings: SecretFile | None = None


STATE_WITHIN: Final = 5.0
"""Seconds for the mDNS gateway to start before it is reported as missing."""

_NEWEST_OF_EACH: Final = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class HomekitGateway(Gateway):
    """Gateway to HomeKit accessories; a :class:`HomekitPort` of its host is used in place of the library."""

    Settings: ClassVar[type[BaseModel]] = HomekitGatewaySettings

    def __init__(self, node: Node, settings: HomekitGatewaySettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._mdns = GatewayNames(settings.mdns)
        self._problem = (
            f"no gateway {settings.mdns!r} runs, which would find the accessories; add [gateways.{settings.mdns}]"
        )
        self._file = PairingFile.of(self, settings.pairings)
        self._port = self.context.service(HomekitPort)  # type: ignore[type-abstract]
        self._pairings: dict[str, Pairing] = {}
        self._found: dict[str, FoundAccessory] = {}
        self._runners: dict[str, AccessoryRunner] = {}
        self._tasks: TaskGroup | None = None
        self.devices = PublishedDevices(
            self,
            self._perform,
            settings,
            find_problems=lambda: problems_of(self._runners.values()),
            find_notes=self._notes,
        )
        PairingServices(self, node)

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Check the library and the file of the keys."""
        check_extra('the gateway "homekit"', "homekit", "aiohomekit")
        if isinstance(settings, HomekitGatewaySettings):
            PairingFile(settings.pairings).load()

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Follow the accessories on the network until cancelled; ready once the state of the mDNS gateway is known."""
        if self._port is None:
            library = await to_thread.run_sync(
                import_module, "homebot.integrations.homekit.gateway.aiohomekit_port"
            )  # takes long
            self._port = library.AiohomekitPort()
        self._pairings = dict(await to_thread.run_sync(self._file.load))
        states = self.node.create_subscription(GatewayState, self._mdns.state, None, _NEWEST_OF_EACH)
        sightings = self.node.create_subscription(
            Sighting, self._mdns.received_topics, None, _NEWEST_OF_EACH, from_node=self._mdns.node
        )
        async with anyio.create_task_group() as self._tasks:
            with anyio.move_on_after(STATE_WITHIN):
                self._follow_state(await states.receive())
            if self._state is None:
                self.publish_state("unavailable", self._problem)
            self.mark_ready(task_status)
            self._tasks.start_soon(run_as, self.node.full_name, partial(self._follow_sightings, sightings))
            async for state in states:
                self._follow_state(state)

    async def pair(self, key: str, code: str) -> str:
        """Pair with an accessory by its setup code, and connect to it; return its name."""
        sighted = self._found.get(key)
        if sighted is None or self._port is None:
            raise LinkError(f"{key[:40]} is not on the network now")
        if not code:
            raise UnableError(f"{sighted.name} is paired by the code on it: homebot pair '{sighted.name}' CODE")
        if sighted.is_paired and key not in self._pairings:
            raise UnableError(_next_step(sighted))
        if key in self._runners and self._runners[key].link is not None:
            raise UnableError(f"{sighted.name} is paired with homebot already")
        pairing = await self._port.pair(sighted, read_homekit_digits(code))
        await self._save_pairings({**self._pairings, key: pairing})
        self._stop(key)
        self._start(sighted)
        return sighted.name

    async def unpair(self, key: str) -> str:
        """End the pairing with an accessory, and return its name; if it is away, only delete its key."""
        runner = next((runner for runner in self._runners.values() if key in runner.keys), None)
        if runner is not None and key != runner.key:
            raise UnableError(f"{key} is behind the bridge {runner.name}, which is paired as a whole")
        if key not in self._pairings:
            raise UnableError(f"{key[:40]} is not paired with homebot")
        link = None if runner is None else runner.link
        if link is not None:
            await link.unpair()
        await self._save_pairings({other: keys for other, keys in self._pairings.items() if other != key})
        self._stop(key)
        for device in (key,) if runner is None else runner.keys:
            self.devices.remove(device, "it is not paired any more")
        if sighted := self._found.get(key):
            self._found[key] = replace(sighted, is_paired=link is None)  # until it announces that itself
            self.devices.put(describe(sighted).device, "it is announced")
        return key if runner is None else runner.name

    def unpaired(self) -> Iterator[UnpairedDevice]:
        """Yield the accessories without a key."""
        for key, sighted in self._found.items():
            if key not in self._pairings:
                problem = _next_step(sighted) if sighted.is_paired else ""
                yield UnpairedDevice(
                    device=key, name=sighted.name, takes_code=True, within_s=PAIRS_WITHIN, problem=problem
                )

    async def _save_pairings(self, pairings: dict[str, Pairing]) -> None:
        await self._file.keep(pairings)
        self._pairings = pairings

    def _start(self, sighted: FoundAccessory) -> None:
        if self._tasks is not None and self._port is not None:
            runner = AccessoryRunner(sighted, self._pairings[sighted.id], self.devices, self._port)
            self._runners[sighted.id] = runner
            self._tasks.start_soon(run_as, self.node.full_name, runner.run)

    def _stop(self, key: str) -> None:
        if (runner := self._runners.pop(key, None)) is not None:
            runner.stop()

    def _follow_state(self, state: GatewayState) -> None:
        self.publish_state(state.state, state.reason if state.state == "unavailable" else "")

    async def _follow_sightings(self, sightings: Subscription[Sighting]) -> None:
        async for sighting in sightings:
            if not self.devices.admits(sighting.key):
                continue
            try:
                sighted = FoundAccessory.of(sighting)
            except WireError as exc:
                self.devices.reject(sighting.key, b"", str(exc))
                continue
            if sighted is not None and sighting.kind == "removed":
                self._found.pop(sighted.id, None)
                if sighted.id not in self._pairings:
                    self.devices.remove(sighted.id, "it is not announced any more")
            elif sighted is not None:
                self._found[sighted.id] = sighted
                if (runner := self._runners.get(sighted.id)) is not None:
                    runner.change(sighted)
                elif sighted.id in self._pairings:
                    self._start(sighted)
                else:
                    self.devices.put(describe(sighted).device, "it is announced")

    def _notes(self) -> Iterator[str]:
        waiting = (sighted for key, sighted in self._found.items() if key not in self._pairings)
        return map(_next_step, islice(waiting, MAX_PROBLEMS))

    async def _perform(self, command: Command) -> Collection[str]:
        runner = next((runner for runner in self._runners.values() if command.key in runner.keys), None)
        if runner is None:
            raise LinkError(f"{command.key[:100]} is not paired with homebot")
        return await runner.perform(command)


def _next_step(sighted: FoundAccessory) -> str:
    """Return why an accessory is not used, and the next step."""
    command = f"`homebot pair '{sighted.name}' CODE`"
    if sighted.is_paired:
        return f"{sighted.name}: it is paired with another controller; remove it there, or reset it, then {command}"
    return f"{sighted.name}: it is not paired yet; {command}, with the code that is printed on it"
