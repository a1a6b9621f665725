"""The components ``button`` and ``scene``: what is pressed or called, and has no state. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/button.py`` and ``scene.py``.
"""

from __future__ import annotations

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity

__all__ = ["build_button", "build_scene"]


def build_button(config: DiscoveryConfig) -> DescribedPart:
    """Describe a button. One that makes the device show or sound where it is takes ``locate`` as well."""
    command = config.required_command()
    payload = config.text("payload_press", "PRESS")
    entity = Entity(config, "x_setting")
    entity.add_push("push", command, payload)
    if config.text("device_class") == "identify":
        entity.add_push("locate", command, payload)
    return entity.build()


def build_scene(config: DiscoveryConfig) -> DescribedPart:
    """Describe a scene."""
    entity = Entity(config, "x_scene")
    entity.add_push("scene", config.required_command(template_key=""), config.text("payload_on", "ON"))
    return entity.build()
