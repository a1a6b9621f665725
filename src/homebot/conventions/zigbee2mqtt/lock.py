"""Door locks that Zigbee2MQTT knows. Pure.

Source: zigbee2mqtt.io, Usage > Exposes > lock.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from homebot.conventions.command_values import require_option
from homebot.conventions.decode import NO_READINGS, JsonMessage, Readings
from homebot.conventions.description import DescribedPart, Publication
from homebot.conventions.part_builder import JsonPart
from homebot.conventions.zigbee2mqtt.device_topics import Zigbee2MqttTopics
from homebot.conventions.zigbee2mqtt.expose import Expose
from homebot.conventions.zigbee2mqtt.features import same_scalar
from homebot.devices.value import PlainValue

__all__ = ["FEATURES_OF_LOCK", "build_lock"]

FEATURES_OF_LOCK = frozenset({"state", "lock_state"})


def build_lock(part: JsonPart, topics: Zigbee2MqttTopics, lock: Expose) -> DescribedPart:
    """Describe a lock. A bolt that is not fully out counts as unlocked, which is the careful reading."""
    state, bolt = lock.feature("state"), lock.feature("lock_state")
    part.read_from(topics.state, partial(_read, state, bolt))
    writer = partial(_write, topics, state) if state is not None and state.is_settable else None
    is_readable = any(one is not None and one.is_published for one in (state, bolt))
    part.add_capability("lock", readable=is_readable, writer=writer, options=("locked", "unlocked"))
    part.add_command_topics(topics.command)
    part.add_state_request(*topics.request_state(state))
    return part.build()


_BOLTS: Mapping[str, str] = {"locked": "locked", "unlocked": "unlocked", "not_fully_locked": "unlocked"}


def _read(state: Expose | None, bolt: Expose | None, message: JsonMessage) -> Readings:
    if state is not None and state.key in message:
        value = message[state.key]
        if value is None:
            return {"lock": None}
        for position, expected in (("locked", state.value_on), ("unlocked", state.value_off)):
            if same_scalar(value, expected):
                return {"lock": position}
        return NO_READINGS
    bolt_state = message.get(bolt.key) if bolt is not None else None
    return {"lock": _BOLTS[bolt_state]} if isinstance(bolt_state, str) and bolt_state in _BOLTS else NO_READINGS


def _write(topics: Zigbee2MqttTopics, state: Expose, value: PlainValue, _transition: float) -> tuple[Publication, ...]:
    target = require_option("lock", value, ("locked", "unlocked"))
    return topics.publish({state.key: state.value_on if target == "locked" else state.value_off})
