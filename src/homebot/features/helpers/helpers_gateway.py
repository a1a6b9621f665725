"""The gateway with the helpers of ``[helpers]`` as devices. Commands set them, and their values are kept."""

import json
import math
from collections.abc import Mapping
from contextlib import closing
from typing import ClassVar, Final, NamedTuple, final

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.devices.device import KeyValue
from homebot.devices.gateway_messages import Command
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import ServiceError
from homebot.features.helpers import KEEP_VALUES
from homebot.features.helpers.messages import KeepHelperValues, KeepHelperValuesRequest
from homebot.features.helpers.settings import (
    MAX_TIMER_S,
    ButtonHelper,
    HelperSetting,
    HelpersSettings,
    NumberHelper,
    TextHelper,
    TimeHelper,
    TimerHelper,
)
from homebot.gateways.announced.gateway_device import GatewayDevice, can_report
from homebot.gateways.announced.published_devices import PublishedDevices
from homebot.gateways.base import Gateway, GatewayContext
from homebot.graph import EntityKind, Node

UNKEPT: Final = "helpers.not_kept"

_SEEN_EVERY: Final = 900.0
"""Seconds after which the helpers are published again, so that they do not become stale."""

_NEVER: Final = math.inf
_MINUTES: Final = "number"
_PUSH: Final = "push"
_PATIENCE_S: Final = 10.0


class _Helper(NamedTuple):
    part: Part
    first: PlainValue
    seconds: float = 0.0


@final
class HelpersGateway(Gateway):
    """Each helper is a device with one value; a timer turns itself off, and reports ``press finished`` then.

    To set the minutes of a timer starts it for so long.
    """

    Settings: ClassVar[type[BaseModel]] = HelpersSettings

    def __init__(self, node: Node, settings: HelpersSettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._helpers = {name: _helper(setting) for name, setting in settings.helpers.items()}
        self._values = {name: helper.first for name, helper in self._helpers.items()}
        self._due: dict[str, float] = {}
        self._changed = anyio.Event()
        self._devices = PublishedDevices(self, self._perform, settings)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Report the kept values, and then end timers, until cancelled."""
        self.publish_state("active")
        task_status.started()
        graph, only = self.node.graph, (EntityKind.SERVICE, KEEP_VALUES.name)
        with anyio.move_on_after(_PATIENCE_S), graph.watch(only=only) as changes:  # features start after gateways
            if graph.get_service_type(KEEP_VALUES.name) is None:
                await anext(changes)
        for name, text in (await self._save_values({})).items():
            helper = self._helpers.get(name)
            value = _plain(text)
            if helper and not helper.seconds and helper.first is not None and _takes(helper.part, value):
                self._values[name] = value
        self._publish()
        for name, helper in self._helpers.items():
            if helper.first is not None:
                await self._report(name)
        clock = self.node.graph.clock
        while True:
            self._changed = anyio.Event()
            now = clock.monotonic()
            for name in [name for name, due in self._due.items() if due <= now]:
                del self._due[name]
                await self._set(name, value=False)
                await self._devices.report(name, {"press": "finished"})
            with anyio.move_on_after(min(self._due.values(), default=_NEVER) - now if self._due else _SEEN_EVERY):
                await self._changed.wait()
            self._publish()

    def _publish(self) -> None:
        for name, helper in self._helpers.items():
            self._devices.put(GatewayDevice(name, name.replace("_", " "), (helper.part,)), "it is in [helpers]")

    async def _perform(self, command: Command) -> None:
        value, seconds = command.value.plain(), self._helpers[command.key].seconds
        if command.capability == _PUSH:
            await self._devices.report(command.key, {"press": "pressed"})
            return
        if seconds and command.capability == _MINUTES and isinstance(value, float):
            await self._devices.report(command.key, {_MINUTES: value})
            value, seconds = True, 60 * value
        if seconds and value:
            self._due[command.key] = self.node.graph.clock.monotonic() + seconds
        else:
            self._due.pop(command.key, None)
        self._changed.set()
        await self._set(command.key, value=value)

    async def _set(self, name: str, *, value: PlainValue) -> None:
        self._values[name] = value
        await self._report(name)
        await self._save_values({name: json.dumps(value)})

    async def _report(self, name: str) -> None:
        capability = self._helpers[name].part.capabilities[0].name
        await self._devices.report(name, {capability: self._values[name]})

    async def _save_values(self, values: Mapping[str, str]) -> dict[str, str]:
        request = KeepHelperValuesRequest(values=tuple(KeyValue(key=name, value=text) for name, text in values.items()))
        try:
            with closing(self.node.create_client(KeepHelperValues, KEEP_VALUES.name)) as client:
                answer = await client.call(request)
        except ServiceError as exc:
            self.node.log.warning(UNKEPT, message=f"the values of helpers are not kept: {exc}")
            return {}
        return {value.key: value.value for value in answer.values}


def _helper(setting: HelperSetting) -> _Helper:
    match setting:
        case bool():
            return _Helper(_part(Capability(name="on_off", settable=True)), setting)
        case TimerHelper():
            finished = Capability(name="press", options=("finished",))
            minutes = Capability(name=_MINUTES, settable=True, unit="min", bounds=(1 / 60, MAX_TIMER_S / 60))
            part = _part(Capability(name="on_off", settable=True), finished, minutes)
            return _Helper(part, first=False, seconds=setting.timer)
        case TimeHelper():
            return _Helper(_part(Capability(name="text", settable=True)), setting.time)
        case TextHelper():
            return _Helper(_part(Capability(name="text", settable=True)), setting.text)
        case ButtonHelper():
            pressed = Capability(name="press", options=("pressed",))
            return _Helper(_part(pressed, Capability(name=_PUSH, settable=True, readable=False)), None)
        case NumberHelper():
            step = (0.0, 1.0) if setting.counter is not None else ()
            bounds = (setting.low, setting.high)
            return _Helper(_part(Capability(name="number", settable=True, bounds=bounds, grid=step)), setting.first)
        case tuple():
            return _Helper(_part(Capability(name="option", settable=True, options=setting)), setting[0])
    return _Helper(_part(Capability(name="number", settable=True)), float(setting))


def _part(*capabilities: Capability) -> Part:
    return Part(id="", service_type="x_setting", capabilities=capabilities)


def _plain(text: str) -> PlainValue:
    """Return a kept value; None for one that cannot be read."""
    try:
        value = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return float(value) if type(value) is int else value if isinstance(value, bool | float | str) else None


def _takes(part: Part, value: PlainValue) -> bool:
    """Return whether the helper still has such values."""
    capability = part.capabilities[0]
    is_chosen = not capability.options or value in capability.options
    is_within = not capability.bounds or (
        isinstance(value, float) and capability.bounds[0] <= value <= capability.bounds[1]
    )
    return value is not None and is_chosen and is_within and can_report(part, capability.name, value)
