"""Settings of gateways and apps as parameters of their nodes.

They are read-only, since tables of the configuration are read at the start.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Final

from pydantic import BaseModel

from homebot.graph import Node, ParameterDescriptor
from homebot.graph.parameters import Value

__all__ = ["declare_settings"]

_ATTRIBUTE: Final = re.compile(r"^ {4}(\w+): (.+(?:\n {8,}.+)*)", re.MULTILINE)
_LOGIN: Final = re.compile(r"(?<=://)[^/\s]*@")


def declare_settings(node: Node, settings: BaseModel) -> None:
    """Declare the values in *settings* as parameters of *node*; those in tables have names with dots.

    Left out is what no parameter can hold: what is not set, secrets, and lists of tables.
    """
    for name, value, description in _values(settings):
        if not node.parameters.has(name):
            node.declare_parameter(name, value, ParameterDescriptor(description, read_only=True))


def _values(settings: BaseModel, prefix: str = "") -> Iterator[tuple[str, Value, str]]:
    texts = _descriptions(type(settings))
    for key, value in settings:
        name, field = f"{prefix}{key}", type(settings).model_fields.get(key)
        if field is not None and not field.repr:  # a secret
            continue
        if isinstance(value, BaseModel):
            yield from _values(value, f"{name}.")
        elif (plain := _plain(value)) is not None:
            yield name, plain, texts.get(key, "")


def _plain(value: object) -> Value | None:
    """Return *value* as a parameter can hold it, without the login in an address; None if none can."""
    match value:
        case bool() | int() | float():
            return value
        case str() | Path():
            return _LOGIN.sub("", str(value))
        case tuple() | list() | frozenset():
            items = [_plain(item) for item in value]
            texts = [item for item in items if isinstance(item, str)]
            numbers = [item for item in items if isinstance(item, int | float) and not isinstance(item, bool)]
            if len(texts) == len(items):
                return tuple(texts)
            return tuple(map(float, numbers)) if len(numbers) == len(items) else None
    return None


def _descriptions(kind: type[BaseModel]) -> dict[str, str]:
    """Return the texts about the attributes in the docstrings of *kind* and its bases."""
    docs = (inspect.getdoc(base) or "" for base in reversed(kind.__mro__) if issubclass(base, BaseModel))
    found = chain.from_iterable(_ATTRIBUTE.findall(doc) for doc in docs)
    return {name: " ".join(text.split()).replace("``", "") for name, text in found}
