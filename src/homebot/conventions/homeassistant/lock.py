"""The component ``lock``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/lock.py``; Zigbee2MQTT 1.42, ``lib/extension/homeassistant.ts``.
"""

from __future__ import annotations

from homebot.conventions.command_values import require_option
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.homeassistant.topics import CommandTopic
from homebot.conventions.payload import NO_READINGS, Readings, shown
from homebot.devices.value import PlainValue
from homebot.errors import WrongCodeError

__all__ = ["build_lock"]

_STATES = ("unlocked", "locked", "unlocking", "open", "locking", "opening", "jammed")
"""The later of two states with the same payload counts."""


def build_lock(config: DiscoveryConfig) -> DescribedPart:
    """Describe a door lock, or a setting where it only keeps children from the keys of a device.

    A door lock that wants a code is commanded with one, and judges it itself. Of the config's ``code_format`` nothing
    is checked but that it is there: it is a stranger's regular expression.
    """
    command = config.required_command()
    if config.discovery_id.rpartition("/")[2] in _KEY_LOCKS:
        return _key_lock(config, command)
    states: dict[str, str | None] = {config.text(f"state_{state}", state.upper()): state for state in _STATES}
    states[config.text("payload_reset", "None")] = None
    payloads = {"locked": config.text("payload_lock", "LOCK"), "unlocked": config.text("payload_unlock", "UNLOCK")}
    if config.has("payload_open"):
        payloads["open"] = config.text("payload_open")

    wants_code = config.has("code_format")

    def read(text: str) -> Readings:
        return {"lock": states[text]} if text.strip() and text in states else NO_READINGS

    def write(value: PlainValue, code: str) -> Publications:
        if wants_code and not code:
            raise WrongCodeError(f"lock {shown(value)}", "it needs a code")
        return (command.publication_with_code(payloads[require_option("lock", value, payloads)], code),)

    entity = Entity(config, "door_lock")
    entity.add_coded_capability("lock", write, readable=entity.read_text_from(config.source("state_topic"), read))
    entity.add_commands(command)
    return entity.build()


_KEY_LOCKS = frozenset({"child_lock", "keypad_lock"})
"""What Zigbee2MQTT calls those of its locks that lock no door."""


def _key_lock(config: DiscoveryConfig, command: CommandTopic) -> DescribedPart:
    payloads = {True: config.text("payload_lock", "LOCK"), False: config.text("payload_unlock", "UNLOCK")}
    states: dict[str, bool | None] = {
        config.text("state_unlocked") or payloads[False]: False,
        config.text("state_locked") or payloads[True]: True,
        config.text("payload_reset", "None"): None,
    }
    entity = Entity(
        DiscoveryConfig(config.component, config.discovery_id, {"entity_category": "config", **config.values}),
        "x_setting",
    )
    entity.add_flag("on_off", config.source("state_topic"), command, payloads, states)
    return entity.build()
