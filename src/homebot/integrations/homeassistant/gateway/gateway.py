"""The Home Assistant gateway: the devices of a Home Assistant, over its WebSocket.

Source: Home Assistant core 2024.3, ``components/device_automation`` and ``websocket_api``: only the token of an
administrator may follow triggers.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Collection, Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext, suppress
from typing import ClassVar, Final

import anyio
import anyio.lowlevel
from pydantic import BaseModel

from homebot.conventions.entity_rows import Fields
from homebot.conventions.joint_message import join
from homebot.conventions.payload import as_fields, compact_json, shown, text_of
from homebot.devices.gateway_messages import Command
from homebot.devices.part import Capability, Part
from homebot.errors import RefusedError, UsageError, WireError
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import GatewayContext
from homebot.gateways.linked_gateway import LinkedGateway
from homebot.graph import Node
from homebot.integrations.homeassistant.formats.states.domains import DOMAINS
from homebot.integrations.homeassistant.formats.states.entity import HomeAssistantEntity, ServiceCall
from homebot.integrations.homeassistant.formats.states.presses import APP_EVENTS, REMOTE_EVENTS, read_pressed
from homebot.integrations.homeassistant.formats.states.registries import REGISTRIES
from homebot.integrations.homeassistant.gateway.entities import HomeAssistantEntities
from homebot.integrations.homeassistant.gateway.link import GREETS_WITHIN, HomeAssistantLink, connected
from homebot.integrations.homeassistant.gateway.settings import HOW_TO_LOG_IN, HomeAssistantGatewaySettings
from homebot.support.isolation import ungrouped

_MAX_TRIGGERS: Final = 100
"""Triggers of one device."""


class DeviceTriggers:
    """The triggers of devices, over one connection.

    Args:
        on_press: Receives the key of a device, the id of its part and the press.
    """

    def __init__(self, link: HomeAssistantLink, on_press: Callable[[str, str, str], Awaitable[None]]) -> None:
        self._link = link
        self._on_press = on_press
        self._asked: dict[str, tuple[Part, ...]] = {}

    async def follow(self, device_ids: Iterable[str]) -> dict[str, tuple[Part, ...]]:
        """Follow the triggers of new devices; return the parts of each device with triggers."""
        for device_id in device_ids:
            if device_id not in self._asked:
                self._asked[device_id] = await self._subscribe(device_id)
        return {device_id: parts for device_id, parts in self._asked.items() if parts}

    async def _subscribe(self, device_id: str) -> tuple[Part, ...]:
        try:
            listed = await self._link.call("the triggers", "device_automation/trigger/list", {"device_id": device_id})
            triggers = (
                [trigger for trigger in listed if _is_own(trigger)][:_MAX_TRIGGERS] if isinstance(listed, list) else []
            )
            if not triggers:
                return ()
            parts = tuple(map(_part, triggers))

            async def on_trigger(event: Mapping[str, object]) -> None:
                number = text_of(as_fields(as_fields(event.get("variables")).get("trigger")).get("idx"))
                if number.isdecimal() and int(number) < len(parts):
                    part = parts[int(number)]
                    await self._on_press(device_id, part.id, part.capabilities[0].options[0])

            await self._link.call("the triggers", "subscribe_trigger", {"trigger": triggers}, on_trigger)
        except RefusedError:  # an integration without triggers, or a user without the right to follow them
            return ()
        return tuple({part.id: part for part in parts}.values())


def _is_own(trigger: object) -> bool:
    """Return whether a trigger belongs neither to an entity, which reports it anyway, nor to MQTT discovery."""
    fields = as_fields(trigger)
    return bool(fields) and "entity_id" not in fields and fields.get("domain") not in {*DOMAINS, "mqtt"}


def _part(trigger: Mapping[str, object]) -> Part:
    """Return the part of a trigger: one for each, as in MQTT discovery."""
    kind, subtype = text_of(trigger.get("type")), text_of(trigger.get("subtype"))
    press = Capability(
        name="press", options=(subtype if kind == "action" and subtype else f"{kind} {subtype}".strip(),)
    )
    part_id = f"{kind}_{subtype}".strip("_")
    return Part(
        id=part_id, service_type="generic_switch", advertised="device_automation", tag=kind, capabilities=(press,)
    )


SETTLES: Final = 0.05
MAX_SETTLING_S: Final = 0.5
"""Least and most seconds for which changes of the registries are collected, as a new device is a change per entity.
Within these, four times the duration of the last listing, so that listing takes at most a fifth of the time."""

FORGOTTEN_AFTER: Final = 300.0
"""Seconds after which an entity without state and entry counts as gone: a reload takes a few seconds, a start of Home
Assistant may take minutes."""


class HomeAssistantGateway(LinkedGateway):
    """Brings the devices of a Home Assistant onto the graph."""

    Settings: ClassVar[type[BaseModel]] = HomeAssistantGatewaySettings
    peer = "Home Assistant"
    knows_people = True
    _link: HomeAssistantLink

    def __init__(
        self, node: Node, settings: HomeAssistantGatewaySettings, context: GatewayContext | None = None
    ) -> None:
        super().__init__(node, settings, context)
        self._settings = settings
        self._entities = HomeAssistantEntities(settings.max_entities)
        self._stale: set[str] = set()
        self._changed = anyio.Event()
        self._forgot_at = 0.0
        self.devices = PublishedDevices(
            self,
            self._perform,
            settings,
            refresh=self._refresh,
            max_devices=settings.max_entities,
            find_problems=self._problems,
        )
        self.offer_pictures(self._read_picture)

    @classmethod
    def check(cls, settings: BaseModel) -> None:
        """Check the token."""
        if isinstance(settings, HomeAssistantGatewaySettings):
            try:
                settings.read_token()
            except UsageError as exc:
                raise UsageError(f"{exc}; {HOW_TO_LOG_IN}") from exc

    @classmethod
    async def reach(cls, settings: BaseModel) -> None:
        """Log in to Home Assistant."""
        if isinstance(settings, HomeAssistantGatewaySettings):
            async with connected(settings, lambda _payload, _why: None):
                pass

    async def connect(self) -> None:
        """Connect, and follow Home Assistant until the link is lost."""
        async with connected(self._settings, self.on_invalid) as self._link:
            with ungrouped():
                async with anyio.create_task_group() as tasks:
                    tasks.start_soon(self._link.read)
                    await self._load()
                    self._forgot_at = self.node.graph.clock.monotonic()
                    self.on_link()
                    await self._follow_presses()
                    await self._follow_registries(DeviceTriggers(self._link, self._on_press))

    async def _load(self) -> None:
        """Read the registries and all states, and follow both."""
        link = self._link
        config = as_fields(await link.call("the configuration", "get_config", within=GREETS_WITHIN))
        self._entities.celsius = as_fields(config.get("unit_system")).get("temperature") != "°F"
        for registry in REGISTRIES:
            args = {"event_type": f"{registry}_registry_updated"}
            with _suppress_refusal(registry):
                await link.call("the registries", "subscribe_events", args, self._on_registry)
        with suppress(RefusedError):
            self._entities.own_user = text_of(as_fields(await link.call("the user", "auth/current_user")).get("id"))
        await self._list(set(REGISTRIES))
        self._entities.lose_all()
        loaded = anyio.Event()

        async def on_states(event: Mapping[str, object]) -> None:
            is_first = not loaded.is_set()
            for field, is_new in (("a", True), ("c", False)):
                for entity_id, change in as_fields(event.get(field)).items():
                    await self._on_state(entity_id, change, is_new=is_new, is_first=is_first)
            removed = event.get("r", [])
            for entity_id in removed if isinstance(removed, list) else ():
                entity = self._entities.lose(entity_id) if isinstance(entity_id, str) else None
                if entity is not None:
                    await self._report(entity)
            if not event.keys() & {"a", "c", "r"}:
                raise WireError(f"an event of states has {shown(sorted(event))}")
            await anyio.lowlevel.checkpoint()
            loaded.set()

        await link.call("the states", "subscribe_entities", None, on_states)
        await loaded.wait()
        await self._describe_all("Home Assistant listed it")

    async def _list(self, registries: set[str]) -> None:
        for registry in REGISTRIES:
            if registry in registries:
                with _suppress_refusal(registry):
                    listed = await self._link.call(f"the {registry}s", f"config/{registry}_registry/list")
                    if registry == "entity" and isinstance(listed, list):  # the list omits the aliases
                        ids = [text_of(as_fields(row).get("entity_id")) for row in listed]
                        with suppress(RefusedError):  # it came in 2023.2
                            args = {"entity_ids": ids}
                            rows = await self._link.call("the aliases", "config/entity_registry/get_entries", args)
                            listed = list(as_fields(rows).values()) or listed
                    self._entities.registries.put(registry, listed)

    async def _follow_registries(self, triggers: DeviceTriggers) -> None:
        """Follow the triggers of all devices; read changed registries again, and regroup the entities."""
        clock, settles = self.node.graph.clock, SETTLES
        while True:
            self._entities.triggers = await triggers.follow(self._entities.registries.device_ids)
            if self._entities.triggers:
                await self._describe_all("Home Assistant listed its triggers")
            await self._changed.wait()
            await anyio.sleep(settles)
            self._changed = anyio.Event()
            stale, self._stale = self._stale, set()
            began = clock.monotonic()
            await self._list(stale)
            await self._describe_all("Home Assistant described it anew")
            settles = min(max(SETTLES, 4 * (clock.monotonic() - began)), MAX_SETTLING_S)

    async def _follow_presses(self) -> None:
        """Follow the events that are presses; a user without the right to do so has none."""
        for kind in (*APP_EVENTS, *REMOTE_EVENTS):
            with suppress(RefusedError):
                await self._link.call("the presses", "subscribe_events", {"event_type": kind}, self._on_pressed)

    async def _on_pressed(self, event: Mapping[str, object]) -> None:
        if (pressed := read_pressed(event)) is not None and pressed.key in self.devices.keys:
            await self._on_press(*pressed)

    async def _on_press(self, key: str, part: str, press: str) -> None:
        if self.devices.admits(key):
            await self.devices.report(key, {"press": press}, part)

    async def _on_registry(self, event: Mapping[str, object]) -> None:
        self._mark_stale(text_of(event.get("event_type")).removesuffix("_registry_updated"))

    def _mark_stale(self, *registries: str) -> None:
        self._stale.update(registries)
        self._changed.set()

    async def _on_state(self, entity_id: str, change: object, *, is_new: bool, is_first: bool) -> None:
        key = self._entities.key_of(entity_id)
        source = key or entity_id
        if not self.devices.admits(source):
            return
        try:
            known = self._entities.put(entity_id, change, is_new=is_new)
        except WireError as exc:
            self.devices.reject(source, compact_json(change).encode(), str(exc))
            return
        if known is None or is_first:
            return
        entity, is_described_anew = known
        if not key:
            if self._entities.is_new(entity_id):
                self._mark_stale("device", "entity")  # or its id has changed
            return
        if is_described_anew:
            self.devices.put(self._entities.describe(key), "its abilities changed")
            if entity.is_group:
                self._mark_stale()  # a group that it is in has other members too
        await self._report(entity, compact_json({entity_id: change}).encode(), is_event=not is_new)

    async def _report(self, entity: HomeAssistantEntity, message: bytes = b"", *, is_event: bool = False) -> None:
        """Report the values of an entity.

        Args:
            is_event: Whether the message is a change rather than a whole state.
        """
        key = self._entities.key_of(entity.entity_id)
        if not key:
            return
        entities = self._entities.of(key)
        if entity.is_available:
            self.devices.put(self._entities.device(key), "it reported")
        if message:
            await self.devices.deliver_raw(key, message)
        if len(entities) > 1:
            self.devices.report_reachable(key, entity.entry.part_id, reachable=entity.is_available)
        self.devices.report_reachable(key, reachable=self._entities.is_reached(key))
        values = entity.read(is_change=is_event)
        if values:
            set_by = entity.set_by(self._entities.own_user) if is_event else ""
            await self.devices.report(key, values, entity.entry.part_id, set_by=set_by)

    async def _describe_all(self, why: str, *, forget: bool = False) -> None:
        """Regroup the entities, remove devices that are gone, and publish new or changed ones."""
        groups, known = self._entities.regroup(forget=forget), set(self.devices.keys)
        for key in known - groups.keys():
            self.devices.remove(key, "Home Assistant no longer has it")
        for key, entities in groups.items():
            before = self._entities.device(key) if key in known and not self.problem else None
            described = self._entities.describe(key)
            if described == before:
                continue
            self.devices.put(described, why, confirmed=self._entities.is_reached(key))
            for entity in entities:
                await self._report(entity)
            await anyio.lowlevel.checkpoint()

    async def maintain(self) -> None:
        """Forget the entities that are gone."""
        now = self.node.graph.clock.monotonic()
        if now - self._forgot_at >= FORGOTTEN_AFTER:
            self._forgot_at = now
            await self._describe_all("Home Assistant reaches it", forget=True)

    def _problems(self) -> tuple[str, ...]:
        count = self._entities.left_out
        return (f"{count} entities of Home Assistant are left out, beyond max_entities",) if count else ()

    async def _perform(self, command: Command) -> Collection[str]:
        self.check_link()
        entity = self._entities.entity(command.key, command.part)

        def write(setting: Command) -> Fields:
            call = entity.call(setting.capability, setting.value.plain(), setting.transition, setting.code)
            alone = {} if call.service == "turn_on" else {"alone": setting.capability}
            return {"service": call.service, "data": dict(call.data), **alone}

        message, along = join(command, write)
        call = ServiceCall(entity.domain, str(message["service"]), entity.entity_id, as_fields(message["data"]))
        args = {
            "domain": call.domain,
            "service": call.service,
            "service_data": dict(call.data),
            "target": {"entity_id": [call.entity_id]},
        }
        what = f"{command.capability} for {entity.entity_id}"
        try:
            await self._link.call(what, "call_service", args)
        except RefusedError as exc:
            if command.code:  # the reason may contain it
                raise RefusedError(what, "Home Assistant refuses it, or the code is wrong") from None
            raise exc from None
        entity.expect(call)
        return along

    async def _read_picture(self, key: str, part: str) -> bytes:
        from homebot.integrations.homeassistant.gateway.pictures import read_picture  # noqa: PLC0415 - if looked at

        entity = self._entities.entity(key, part)
        return await read_picture(self._settings, entity.domain, entity.entity_id)

    async def _refresh(self, key: str, part: str) -> None:
        """Have an entity polled, and of a group its members; Home Assistant reports what has changed."""
        self.check_link()
        entity = self._entities.entity(key, part)
        polled = {"entity_id": list(entity.members or (entity.entity_id,))}
        args = {"domain": "homeassistant", "service": "update_entity", "service_data": polled}
        await self._link.call(f"an update of {entity.entity_id}", "call_service", args)


def _suppress_refusal(registry: str) -> AbstractContextManager[object, bool | None]:
    """Suppress a refusal of floors and labels: they came in 2024.3, which lets only administrators follow them."""
    return suppress(RefusedError) if registry in {"floor", "label"} else nullcontext()
