"""Tables of device types, capabilities, handles and settings, made from the code.

A comment in a page says where one belongs: ``<!-- table of types -->``, ``<!-- keys of MODULE.CLASS -->``.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from importlib import import_module

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined, to_json

from homebot.devices import handles
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.capability_type import CapabilityType
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.handles import Handle

KEYS = re.compile(r"<!-- keys of (\S+)\.(\w+) -->")
_ATTRIBUTE = re.compile(r"^ {4}(\w+): (.+(?:\n {8,}.+)*)", re.MULTILINE)


def on_page_markdown(markdown: str, **_: object) -> str:
    """Put the tables in their places."""
    for name, rows in (("types", _types), ("handles", _handles), ("capabilities", _capabilities)):
        markdown = markdown.replace(f"<!-- table of {name} -->", "\n".join(rows()))
    return KEYS.sub(lambda found: "\n".join(_keys(getattr(import_module(found[1]), found[2]))), markdown)


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


def _handles() -> Iterator[str]:
    yield "| kind | device type | conditions | properties | commands |\n|---|---|---|---|---|"
    for name in handles.__all__:
        kind = getattr(handles, name)
        if isinstance(kind, type) and issubclass(kind, Handle) and kind is not Handle:
            members = [(key, one) for key, one in inspect.getmembers(kind) if not hasattr(Handle, key)]
            cells = (
                sorted(kind.service_types),
                [key for key in inspect.signature(kind.where).parameters if key != "filters"],
                [key for key, one in members if isinstance(one, property)],
                [key for key, one in members if inspect.iscoroutinefunction(one) and not key.startswith("_")],
            )
            yield " | ".join([f"| `{name}`", *(", ".join(f"`{one}`" for one in cell) for cell in cells), ""]).rstrip()


def _keys(settings: type[BaseModel]) -> Iterator[str]:
    """Yield the keys of a table of the configuration, as the docstring of its model explains them."""
    docs = (inspect.getdoc(base) or "" for base in settings.__mro__ if issubclass(base, BaseModel))
    meanings = dict(_ATTRIBUTE.findall("\n".join(docs)))
    yield "| key | default | meaning |\n|---|---|---|"
    inherited = {name for base in settings.__mro__[1:] for name in getattr(base, "model_fields", ())}
    for name, field in sorted(settings.model_fields.items(), key=lambda one: one[0] in inherited):
        meaning = " ".join(meanings[name].split()).replace("``", "`").replace("|", "\\|")
        yield f"| `{name}` | {_default(field)} | {meaning} |"


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "required"
    if field.default in (None, "", (), PydanticUndefined) or isinstance(field.default, BaseModel):
        return ""  # explained with the key
    return f"`{to_json(field.default).decode()}`".replace(".0`", "`")
