"""The components ``button`` and ``scene``: what is pressed or called, and has no state. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/button.py`` and ``scene.py``.
"""

from __future__ import annotations

from functools import partial

from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.gateways.mqtt.description import DescribedPart, Publication
from homebot.gateways.mqtt.homeassistant.command_topic import CommandTopic
from homebot.gateways.mqtt.homeassistant.config import Config
from homebot.gateways.mqtt.homeassistant.entity import Entity
from homebot.gateways.mqtt.payload import shown

__all__ = ["build_button", "build_scene"]


def build_button(config: Config) -> DescribedPart:
    """Describe a button. One that makes the device show or sound where it is can be told ``locate`` as well."""
    command = config.required_command()
    payload = config.text("payload_press", "PRESS")
    entity = Entity(config, "x_setting")
    names = ("push", "locate") if config.text("device_class") == "identify" else ("push",)
    for name in names:
        entity.offers(name, readable=False, writer=partial(_push, name, command, payload))
    entity.listens(command)
    return entity.described()


def build_scene(config: Config) -> DescribedPart:
    """Describe a scene."""
    command = config.required_command(template_key="")
    entity = Entity(config, "x_scene")
    entity.offers("scene", readable=False, writer=partial(_push, "scene", command, config.text("payload_on", "ON")))
    entity.listens(command)
    return entity.described()


def _push(
    name: str, command: CommandTopic, payload: str, value: PlainValue, _transition: float
) -> tuple[Publication, ...]:
    if value is not True:
        raise RefusedError(f"{name} {shown(value)}", "it takes true alone")
    return (command.publication(payload),)
