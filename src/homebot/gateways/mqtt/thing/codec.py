"""How a part of a thing speaks and listens. Pure."""

from __future__ import annotations

from collections.abc import Mapping

from homebot.devices.part import Capability
from homebot.devices.thing import Affordance, Form, Meant, hears, tells
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.gateways.mqtt.description import Publication
from homebot.gateways.mqtt.payload import shown
from homebot.gateways.mqtt.thing.wording import meant_value, spelt_value
from homebot.mqtt.topics import topic_matches

__all__ = ["ThingCodec"]


class ThingCodec:
    """How one part of a thing speaks and listens; see :class:`homebot.gateways.mqtt.description.Codec`.

    Args:
        meant: The part; what it reads and writes is said by its capabilities, whatever its affordances offer.
    """

    def __init__(self, meant: Meant) -> None:
        self._heard: list[tuple[str, Capability, Affordance]] = []
        self._told: dict[str, tuple[Capability, Affordance, Form]] = {}
        for capability, affordance in meant.affordances:
            heard, told = hears(affordance), tells(affordance)
            if capability.readable and heard is not None:
                self._heard.append((heard.filter, capability, affordance))
            if capability.settable and told is not None:
                self._told.setdefault(capability.name, (capability, affordance, told))

    def topics(self) -> tuple[str, ...]:
        """Return the topics that it speaks on."""
        return tuple(dict.fromkeys(topic for topic, _, _ in self._heard))

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Mapping[str, PlainValue]:
        """Return what a message tells; an event that the broker had kept is none."""
        found: dict[str, PlainValue] = {}
        for heard, capability, affordance in self._heard:
            if (retained and affordance.kind == "event") or not (heard == topic or topic_matches(heard, topic)):
                continue
            value = meant_value(capability, affordance, payload)
            if value is not None:
                found[capability.name] = value[0]
        return found

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> tuple[Publication, ...]:
        """Return what to publish; a transition is not spoken of in a Thing Description.

        Raises:
            RefusedError: The part cannot do that, or the value is none of its.
        """
        del transition
        if capability not in self._told:
            known = ", ".join(self._told) or "nothing"
            raise RefusedError(shown(capability), f"this part takes {known}")
        offered, affordance, form = self._told[capability]
        if affordance.kind == "action":
            if value is not True:
                raise RefusedError(f"{capability} {shown(value)}", "it takes true")
            return (Publication(form.topic, b"", form.qos, form.retain),)
        payload = spelt_value(offered, affordance, value, form.content_type)
        return (Publication(form.topic, payload, form.qos, form.retain),)
