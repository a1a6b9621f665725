"""The component ``light``, in the schema that its config names. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/light/__init__.py``.
"""

from __future__ import annotations

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.light_basic import build_basic_light
from homebot.conventions.homeassistant.light_json import build_json_light
from homebot.conventions.homeassistant.light_template import build_template_light
from homebot.conventions.payload import shown
from homebot.errors import WireError

__all__ = ["build_light"]

_SCHEMAS = {"basic": build_basic_light, "json": build_json_light, "template": build_template_light}


def build_light(config: DiscoveryConfig) -> DescribedPart:
    """Describe a lamp."""
    build = _SCHEMAS.get(config.text("schema", "basic").lower())
    if build is None:
        raise WireError(f"light: schema is {shown(config.text('schema'))}, not basic, json or template")
    return build(config)
