"""The component ``lock``. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/lock.py``.
"""

from __future__ import annotations

from homebot.conventions.command_values import require_option
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import NO_READINGS, Readings, shown
from homebot.devices.value import PlainValue
from homebot.errors import WrongCodeError

__all__ = ["build_lock"]

_STATES = ("unlocked", "locked", "unlocking", "open", "locking", "opening", "jammed")
"""The later of two states with the same payload counts."""


def build_lock(config: DiscoveryConfig) -> DescribedPart:
    """Describe a door lock. One that wants a code is commanded with one, and judges it itself.

    Of the config's ``code_format`` nothing is checked but that it is there: it is a stranger's regular expression.
    """
    command = config.required_command()
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
