"""The node of the bridges: exports devices, scenes and routines, carries out what controllers write."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, Final, NamedTuple, final

import anyio
from anyio import to_thread
from anyio.abc import TaskGroup, TaskStatus

from homebot.devices.always_ask import why_it_asks
from homebot.devices.app_messages import ChangeRoutine, ChangeRoutineRequest
from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.client_rights import issuer_of_client
from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.device import Device, DeviceChange, StateChange, is_commanded
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse
from homebot.devices.house_view import HouseView, HouseWatcher
from homebot.devices.names import APPLY_SCENE, CHANGE_ROUTINE, LIST_SCENES, PERFORM_COMMAND
from homebot.devices.outcomes import Outcome
from homebot.devices.part import Capability
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.terms import And, FactIs, NameIs, Or, Query
from homebot.devices.scene_messages import ApplyScene, ApplySceneRequest, ListScenes, ScenesRequest
from homebot.errors import HomebotError, LinkError, ServiceError, UnableError, WireError
from homebot.features.homekit_bridge import FEATURE, GET_PAIRING, PAIRINGS_FILE, UNPAIR, hap
from homebot.features.homekit_bridge.hap import HapBridge
from homebot.features.homekit_bridge.messages import (
    GetHomekitPairing,
    HomekitPairingRequest,
    HomekitPairingResponse,
    HomekitUnpairRequest,
    HomekitUnpairResponse,
    UnpairHomekit,
)
from homebot.features.homekit_bridge.services import SWITCH, PartService, PartValues, Written, services_of
from homebot.gateways.pairing import PairingFile
from homebot.graph import Node
from homebot.log import LogLimit
from homebot.messages.key_value import KeyValue
from homebot.support.counters import Severity
from homebot.support.isolation import run_as
from homebot.words.exact_queries import parse_exact_query

if TYPE_CHECKING:
    from homebot.devices.value import PlainValue
    from homebot.feature_context import FeatureContext
    from homebot.features.homekit_bridge.settings import HomekitBridgeSettings

NOT_KEPT: Final = "homekit_bridge.not_kept"
NOT_SERVED: Final = "homekit_bridge.not_served"
COMMAND_FAILED: Final = "homekit_bridge.command_failed"

APPLE: Final = "apple"
"""The client that commands."""

MAX_BRIDGES: Final = 8
MAX_COMMANDS: Final = 200
"""Commands without an outcome; of more, controllers are told that the house is busy."""

ANSWERS_WITHIN_S: Final = 9.0
"""Seconds after which a controller gets an answer: it waits for ten."""

RETURNS_WITHIN_S: Final = 60.0
"""Seconds for which a restarted bridge waits for the devices that it had: without them, controllers forget them."""

_WAITS: Final = "it waits for devices that it had before the start, for a minute at most; try again"
_GATHERED_S: Final = 1.0
_LOOK_EVERY_S: Final = 60.0
_MAX_WAIT_S: Final = 900.0
_NOT_POLICIES: Final = frozenset({"", "gateway", "device"})
_MAX_LEFT_OUT: Final = 200
_SCENE, _ROUTINE = "scene:", "routine:"
_ORDINARY: Final[tuple[str, ...]] = ("act: ordinary",)


async def serve(house: FeatureContext) -> None:
    """Serve the bridges until cancelled."""
    async with Node(house.graph, FEATURE.name) as node:
        settings: HomekitBridgeSettings = house.table("homekit_bridge")
        bridges = HomekitBridges(node, settings, PairingFile(house.file(PAIRINGS_FILE)), house.home.name)
        await run_as(node.full_name, bridges.serve)


class Exported(NamedTuple):
    """An accessory: a device, or a scene or routine as a switch.

    Attributes:
        key: The id of the device; for others, their kind and name.
        device: None for others.
        scope: The rights with which it is commanded.
    """

    key: str
    name: str
    model: str
    services: tuple[PartService, ...]
    device: Device | None = None
    scope: tuple[str, ...] = _ORDINARY

    @property
    def shape(self) -> object:
        """If it differs, controllers must read the description again."""
        return self.model, tuple((one.key, one.title, one.characteristics()) for one in self.services)


class _Place(NamedTuple):
    bridge: int
    aid: int


@final
class HomekitExports:
    """Decides which devices are exported. Pure."""

    def __init__(self, settings: HomekitBridgeSettings) -> None:
        self._export = tuple(map(parse_exact_query, settings.export))
        self._exclude = tuple(map(parse_exact_query, settings.exclude))

    def of(self, device: Device) -> tuple[Exported | None, str]:
        """Return what is exported of *device*, None for nothing; and why a part of it is left out that fits."""
        parts, problem, scope = [], "", _ORDINARY
        for part in device.parts:
            facets = PartFacets(device, part)
            if not any(fits(query, facets) for query in self._export):
                continue
            if any(fits(query, facets) for query in self._exclude) or part.part.category:
                continue
            asks = why_it_asks(device, part) if is_commanded(part.part) else ""
            is_named = any(fits(query, facets) and _names(query, facets) for query in self._export)
            if asks and not is_named:
                problem = f"{asks}, so it is exported by its name alone: 'name=\"{device.name}\"'"
                continue
            parts.append(part)
            scope = scope if not asks else ("act: ordinary", f'act: name="{device.id}"')
        services = tuple(services_of(device, parts))
        if not services:
            return None, problem or ("HomeKit has no service for it" if parts else "")
        model = next((item.value for item in device.metadata if item.key == "model"), "")
        return Exported(device.id, clean_name(device.name), model, services, device, scope), problem


def clean_name(name: str) -> str:
    """Return *name* in letters, digits, spaces and apostrophes: Apple Home adds no accessory with another sign."""
    signs = (sign if sign.isalnum() or sign == "'" else " " for sign in name)
    return " ".join("".join(signs).split()).strip("'")[:64].strip() or "Device"


def _names(query: Query, facets: PartFacets) -> bool:
    """Return whether a query that fits names its device, rather than a type or a room."""
    if isinstance(query, And | Or):
        return any(fits(term, facets) and _names(term, facets) for term in query.terms)
    return isinstance(query, NameIs) or (isinstance(query, FactIs) and query.name in {"id", "name"})


@final
class HomekitBridges(HouseWatcher):
    """The bridges of a house, the second with what has no place behind the first.

    Args:
        file: Keeps keys, pairings, and the places of accessories.
        name: The name of the home.
        make: Makes a bridge, as :class:`HapBridge` does.
    """

    def __init__(
        self,
        node: Node,
        settings: HomekitBridgeSettings,
        file: PairingFile,
        name: str,
        make: Callable[..., HapBridge] = HapBridge,
    ) -> None:
        self._node, self._settings, self._file, self._make = node, settings, file, make
        self._name = settings.name or name
        self._clock = node.graph.clock
        self._limit = LogLimit(self._clock)
        self._exports = HomekitExports(settings)
        self._control = node.create_client(PerformCommand, PERFORM_COMMAND)
        self._scenes = node.create_client(ListScenes, LIST_SCENES)
        self._apply = node.create_client(ApplyScene, APPLY_SCENE)
        self._change = node.create_client(ChangeRoutine, CHANGE_ROUTINE)
        self._view = HouseView.of(node)
        self._bridges: list[HapBridge] = []
        self._kept: dict[str, dict[str, object]] = {}
        self._places: dict[str, _Place] = {}
        self._awaited: set[str] = set()
        self._shown: dict[str, Exported] = {}
        self._switches: tuple[Exported, ...] = ()
        self._left_out: dict[str, str] = {}
        self._wanted: dict[tuple[str, str], dict[str, PlainValue]] = {}
        self._problem = ""
        self._open = self._refused = self._failed = self._not_kept = 0
        self._changed, self._is_unkept = anyio.Event(), False
        self._tasks: TaskGroup | None = None

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Serve until cancelled."""
        await to_thread.run_sync(hap.read_library)
        self._kept = dict(await to_thread.run_sync(self._file.load))
        self._read_places()
        create = self._node.create_service
        create(GetHomekitPairing, GET_PAIRING.name, self._tell)
        create(UnpairHomekit, UNPAIR.name, self._unpair)
        create(GetHealth, "~/health", self.health)
        try:
            async with anyio.create_task_group() as self._tasks:
                self._view.add(self)
                await self._view.wait_until_complete()
                with anyio.move_on_after(RETURNS_WITHIN_S):
                    while not self._is_whole():
                        await self._next_change()
                await self._update()
                task_status.started()
                while True:
                    await self._next_change()
                    await self._update()
        finally:
            self._tasks = None
            self._view.remove(self)
            with anyio.CancelScope(shield=True):
                await self._keep()

    def on_device(self, change: DeviceChange) -> None:
        """Have the accessories looked at again soon."""
        exported = self._shown.get(change.device.id)
        if exported is not None and change.kind != "removed":
            self._show(exported._replace(name=clean_name(change.device.name), device=change.device))
        self._changed.set()

    def on_values(self, change: StateChange) -> None:
        """Show new values."""
        if (exported := self._shown.get(change.device)) is not None:
            self._show(exported)

    def health(self, _: HealthRequest) -> HealthResponse:
        """Return what is exported, and what was refused, cut off or not kept."""
        counts = {"homekit_accessories": len(self._shown), "homekit_bridges": len(self._bridges)}
        losses = {"homekit_busy": self._refused, "homekit_failed": self._failed, "homekit_not_kept": self._not_kept}
        for bridge in self._bridges:
            for what, number in bridge.lost.items():
                losses[f"homekit_{what}"] = losses.get(f"homekit_{what}", 0) + number
        counted = (*Count.each(counts), *Count.each(losses, Severity.LOSS))
        return HealthResponse(counts=counted, troubles=(self._problem,) if self._problem else ())

    async def _next_change(self) -> None:
        with anyio.move_on_after(_LOOK_EVERY_S if self._settings.scenes else math.inf):
            await self._changed.wait()
        await anyio.sleep(_GATHERED_S)
        self._changed = anyio.Event()

    def _is_whole(self) -> bool:
        """Return whether all accessories are there that were there before the start."""
        there = {device.id for device in self._view.devices if device.parts}
        return all(key in there for key in self._awaited)

    async def _update(self) -> None:
        """Bring the accessories in line with the house."""
        self._switches = await self._find_switches()
        self._left_out.clear()
        wanted: dict[str, Exported] = {switch.key: switch for switch in self._switches}
        for device in sorted(self._view.devices, key=lambda device: device.id):
            exported, problem = self._exports.of(device)
            if exported is not None:
                wanted[device.id] = exported
            if problem and len(self._left_out) < _MAX_LEFT_OUT:
                self._left_out[device.name] = problem
        for key in self._shown.keys() - wanted.keys():
            place = self._places[key]
            self._bridges[place.bridge].remove(place.aid)
            del self._shown[key]
            self._is_unkept = True
        for key, exported in wanted.items():
            before = self._shown.get(key)
            if before is None or before.shape != exported.shape:
                new = await self._place_of(key, wanted)
                if new is None:
                    self._left_out[exported.name] = "there is no place for it behind the bridges"
                    continue
                bridge = self._bridges[new.bridge]
                bridge.put(new.aid, exported.name, exported.model, exported.services, partial(self._write, key))
            self._is_unkept |= before is None
            self._shown[key] = exported
            self._show(exported)
        if not self._bridges:
            await self._begin(0)  # to be paired before anything is there
        for bridge in self._bridges:
            bridge.describe()
        await self._keep()

    async def _find_switches(self) -> tuple[Exported, ...]:
        wanted = self._settings.scenes
        switches = [_switch(_ROUTINE, name) for name in self._settings.routines]
        if wanted:
            try:
                answer = await self._scenes.call(ScenesRequest())
            except ServiceError:
                return self._switches
            own = [scene.name for scene in answer.scenes if not scene.is_native]
            switches += [_switch(_SCENE, name) for name in own if wanted is True or name in (wanted or ())]
        return tuple(switches)

    async def _place_of(self, key: str, wanted: Mapping[str, Exported]) -> _Place | None:
        """Return the place of an accessory: that of before, or a free one, in need that of one that has left."""
        place = self._places.get(key)
        if place is None:
            aid = hap.stable_number(key)
            for number in range(MAX_BRIDGES):
                behind = [other for other, its in self._places.items() if its.bridge == number]
                left = [other for other in behind if other not in wanted]
                if len(behind) >= hap.MAX_ACCESSORIES and left:
                    del self._places[left[0]]
                    behind.remove(left[0])
                if len(behind) < hap.MAX_ACCESSORIES:
                    place = self._places[key] = _Place(number, aid)
                    self._is_unkept = True
                    break
        if place is not None:
            while len(self._bridges) <= place.bridge:
                await self._begin(len(self._bridges))
        return place

    async def _begin(self, number: int) -> None:
        settings = self._settings
        name = self._name if number == 0 else f"{self._name} {number + 1}"
        port = settings.port + number if settings.port else 0
        arguments = name, settings.address, port, self._clock
        more: dict[str, Any] = {"is_announced": settings.is_announced}
        try:
            bridge = self._make(*arguments, self._kept.get(f"bridge {number}", {}), self._on_state, **more)
        except WireError as exc:
            self._node.log.error(NOT_SERVED, message=f"{exc}; a new bridge begins, which must be paired again")
            bridge = self._make(*arguments, {}, self._on_state, **more)
        self._bridges.append(bridge)
        self._is_unkept = True
        if self._tasks is not None:
            self._tasks.start_soon(self._serve_one, bridge)

    async def _serve_one(self, bridge: HapBridge) -> None:
        try:
            await bridge.serve()
        except LinkError as exc:
            self._problem = str(exc)
            self._node.log.error(NOT_SERVED, message=str(exc))

    def _on_state(self) -> None:
        self._is_unkept = True
        self._changed.set()

    def _show(self, exported: Exported) -> None:
        """Show the present values of an accessory."""
        place, view = self._places[exported.key], self._view.get(exported.key)
        values, device = {}, exported.device
        for service in exported.services:
            values[service.key] = service.kind.read(self._values(exported, service))
        is_there = device is None or (
            view is not None and device.freshness != "stale" and device.reachable.state != "no"
        )
        self._bridges[place.bridge].show(place.aid, exported.name, values, is_there=is_there)

    def _values(self, exported: Exported, service: PartService) -> PartValues:
        view = self._view.get(exported.key)
        now: dict[str, PlainValue] = {"on_off": False}
        if exported.device is not None:
            now = {} if view is None else {name: view.value(service.part, name) for name in service.capabilities}
        return PartValues(service.capabilities, now, self._wanted.get((exported.key, service.part), {}))

    async def _write(self, key: str, written: Mapping[str, Written]) -> Mapping[str, int]:
        """Carry out what a controller wrote to an accessory; return HAP's status of each service."""
        statuses: dict[str, int] = {}

        async def write(service: PartService, values: Mapping[str, Any]) -> None:
            statuses[service.key] = await self._write_to(key, service, values)

        async with anyio.create_task_group() as tasks:
            for service in self._shown[key].services if key in self._shown else ():
                if service.key in written:
                    tasks.start_soon(write, service, written[service.key])
        return {service: statuses.get(service, hap.MISSING) for service in written}

    async def _write_to(self, key: str, service: PartService, written: Mapping[str, Any]) -> int:
        exported = self._shown[key]
        if service.kind.write is None or self._tasks is None:
            return hap.READ_ONLY
        settings = service.kind.write(written, self._values(exported, service))
        if not settings:
            return hap.OK
        if self._open >= MAX_COMMANDS:
            self._refused += 1
            return hap.BUSY
        done: list[int] = []
        ended = anyio.Event()
        self._open += 1
        self._tasks.start_soon(self._perform, exported, service, settings, done, ended)
        with anyio.move_on_after(ANSWERS_WITHIN_S):
            await ended.wait()
        is_slow = any(CAPABILITIES.get(name, OWN).is_told_once for name in settings)  # a motor is on its way
        return done[0] if done else hap.OK if is_slow or exported.device is None else hap.NO_RESPONSE

    async def _perform(
        self,
        exported: Exported,
        service: PartService,
        settings: Mapping[str, PlainValue],
        done: list[int],
        ended: anyio.Event,
    ) -> None:
        """Give one command, and have its outcome known."""
        place = exported.key, service.part
        wanted = self._wanted.setdefault(place, {})
        wanted |= settings
        self._show(exported)
        try:
            problem, status = await self._command(exported, service, settings)
        except HomebotError as exc:
            problem, status = str(exc), hap.NO_RESPONSE
        finally:
            self._open -= 1
            for name, value in settings.items():
                if wanted.get(name) == value:
                    wanted.pop(name, None)
            if not wanted:
                self._wanted.pop(place, None)
        done.append(status)
        ended.set()
        if exported.key in self._shown:
            self._show(self._shown[exported.key])
            where = self._places[exported.key]
            self._bridges[where.bridge].repeat(where.aid, service.key)  # the controller has the values that it wrote
        if problem:
            self._failed += 1
            if (held_back := self._limit.allows(exported.key)) is not None:
                message = f"{exported.name}: {problem}"
                self._node.log.warning(COMMAND_FAILED, message=message, device=exported.key, held_back=held_back)

    async def _command(
        self, exported: Exported, service: PartService, settings: Mapping[str, PlainValue]
    ) -> tuple[str, int]:
        """Return the problem of a command, empty for none, and HAP's status."""
        issuer, scope = issuer_of_client(APPLE), exported.scope
        kind, _, name = exported.key.partition(":")
        if exported.device is None:
            if settings.get("on_off") is not True:
                return "", hap.OK
            if kind == _SCENE[:-1]:
                request = ApplySceneRequest(name=name, issuer=issuer, scope=scope)
                applied = await self._apply.call(request, timeout=_MAX_WAIT_S)
                problem, is_done = applied.message, applied.success
            else:
                change = ChangeRoutineRequest(name=name, change="run", issuer=issuer)
                started = await self._change.call(change)
                problem, is_done = started.message, started.success
            return ("", hap.OK) if is_done else (problem, hap.NO_RESPONSE)
        command = CommandRequest(
            device=exported.key,
            part=service.part,
            settings=tuple(Setting.of(capability, value) for capability, value in settings.items()),
            issuer=issuer,
            scope=scope,
        )
        outcome: Outcome = await self._control.call(command, timeout=_MAX_WAIT_S)
        if outcome.succeeded or not outcome.is_failure:
            return "", hap.OK
        return outcome.text, hap.REFUSED if getattr(outcome, "policy", "") not in _NOT_POLICIES else hap.NO_RESPONSE

    def _tell(self, _: HomekitPairingRequest) -> HomekitPairingResponse:
        left_out = tuple(KeyValue(key=name, value=why) for name, why in sorted(self._left_out.items()))
        message = self._problem or ("" if self._bridges else _WAITS)
        bridges = tuple(bridge.info() for bridge in self._bridges)
        return HomekitPairingResponse(success=not message, message=message, bridges=bridges, left_out=left_out)

    async def _unpair(self, _: HomekitUnpairRequest) -> HomekitUnpairResponse:
        count = sum(bridge.unpair() for bridge in self._bridges)
        await self._keep()
        return HomekitUnpairResponse(success=not self._is_unkept, message=self._problem, controllers=count)

    def _read_places(self) -> None:
        for key, place in self._kept.get("places", {}).items():
            match place:
                case [int() as bridge, int() as aid, bool() as was_shown] if 0 <= bridge < MAX_BRIDGES:
                    self._places[key] = _Place(bridge, aid)
                    self._awaited |= {key} if was_shown and not key.startswith((_SCENE, _ROUTINE)) else set()

    async def _keep(self) -> None:
        """Write the file, if anything has changed."""
        if not self._is_unkept:
            return
        self._is_unkept = False
        kept = {f"bridge {number}": bridge.state() for number, bridge in enumerate(self._bridges)}
        unused = {key: value for key, value in self._kept.items() if key.startswith("bridge ") and key not in kept}
        self._kept = {
            **unused,
            **kept,
            "places": {key: [*place, key in self._shown] for key, place in self._places.items()},
        }
        try:
            await self._file.keep(self._kept)
        except UnableError as exc:
            self._is_unkept, self._problem = True, str(exc)
            self._not_kept += 1
            if self._limit.allows(NOT_KEPT) is not None:
                self._node.log.warning(NOT_KEPT, message=f"{exc}; a restart would lose the pairing")


def _switch(kind: str, name: str) -> Exported:
    service = PartService("switch", "", "", SWITCH, {"on_off": Capability(name="on_off", settable=True)})
    return Exported(f"{kind}{name}", clean_name(name), kind.rstrip(":").title(), (service,))
