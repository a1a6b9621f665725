"""Tables of device types and capabilities on the page of devices, made from the code."""

from __future__ import annotations

from collections.abc import Iterator

from homebot.devices.capabilities import CAPABILITIES, CapabilityType
from homebot.devices.device_types import DEVICE_TYPES

TYPES, NAMES = "<!-- table of types -->", "<!-- table of capabilities -->"


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the tables in their places."""
    return markdown.replace(TYPES, "\n".join(_types())).replace(NAMES, "\n".join(_capabilities()))


def _types() -> Iterator[str]:
    yield "| type | other words |\n|---|---|"
    for one in DEVICE_TYPES.values():
        yield f"| `{one.name}` | {', '.join(one.words)} |"


def _capabilities() -> Iterator[str]:
    yield "| capability | value | meaning |\n|---|---|---|"
    for one in CAPABILITIES.values():
        yield f"| `{one.name}` | {_value(one)} | {one.meaning} |"


def _value(one: CapabilityType) -> str:
    if one.options:
        return ", ".join(f"`{option}`" for option in one.options)
    if one.kind != "number":
        return {"bool": "true or false", "text": "text", "numbers": "numbers"}[one.kind]
    bounds = f"{one.bounds[0]:g} to {one.bounds[1]:g}" if one.bounds else "number"
    return f"{bounds} {one.unit}".rstrip()
