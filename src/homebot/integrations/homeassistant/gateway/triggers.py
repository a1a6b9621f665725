"""The triggers of devices, for remotes whose buttons are not entities.

Source: Home Assistant core 2024.3, ``components/device_automation`` and ``websocket_api``: only the token of an
administrator may follow triggers.
"""

from collections.abc import Awaitable, Callable, Iterable, Mapping
from typing import Final

from homebot.conventions.payload import as_fields, text_of
from homebot.devices.part import Capability, Part
from homebot.errors import RefusedError
from homebot.integrations.homeassistant.formats.states.domains import DOMAINS
from homebot.integrations.homeassistant.gateway.link import HomeAssistantLink

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
