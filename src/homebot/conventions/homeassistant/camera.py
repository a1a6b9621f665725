"""The components ``camera`` and ``image``: pictures, which are known to be there but not carried. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/camera.py`` and ``image.py``.
"""

from __future__ import annotations

from dataclasses import replace

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.devices.part import Capability
from homebot.errors import WireError

__all__ = ["build_camera", "build_image"]


def build_camera(config: DiscoveryConfig) -> DescribedPart:
    """Describe a camera: its part names the topic of its pictures, and its codec does not read there."""
    return _seen(config, "camera", config.required_source("topic").topic)


def build_image(config: DiscoveryConfig) -> DescribedPart:
    """Describe a picture, such as the map of a vacuum cleaner, in the same way."""
    topic = config.state_topic("image_topic") or config.state_topic("url_topic")
    if not topic:
        raise WireError("image: it has neither image_topic nor url_topic")
    return _seen(config, "camera", topic)


_IMAGE = Capability(name="image", readable=False)


def _seen(config: DiscoveryConfig, service_type: str, topic: str) -> DescribedPart:
    described = Entity(config, service_type, config.clean_text("device_class") or "image").build()
    return replace(described, part=described.part.model_copy(update={"capabilities": (_IMAGE,), "reads": (topic,)}))
