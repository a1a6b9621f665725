"""The entities of the graph and the fields of its messages, as ``/rosapi`` lists them."""

from __future__ import annotations

import argparse
import base64
import binascii
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import Commands, add_verb
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.devices.wording.json_message import JsonMessage
from homebot.names import is_hidden as is_hidden_name
from homebot.support.names import did_you_mean

if TYPE_CHECKING:
    from homebot.bridges.rosapi.endpoints import EndpointDetails
    from homebot.bridges.rosapi.services import TypeDef


def entities(
    door: DoorClient, *, kind: str = "", name: str = "", node: str = "", elsewhere: bool = False
) -> list[EndpointDetails]:
    """Return the entities of the graph, or those *elsewhere*, sorted by name; an empty text means any."""
    asked = {"kind": kind, "name": name, "node": node, **({"elsewhere": True} if elsewhere else {})}
    response = JsonMessage(door.call("/rosapi/endpoints", asked))
    return cast("list[EndpointDetails]", response.endpoints)


def is_hidden(entity: EndpointDetails) -> bool:
    """Return whether *entity* is shown only on request."""
    return is_hidden_name(entity.name)


def not_yet(door: DoorClient, topic: str) -> str:
    """Return the remark that the missing *topic* is awaited, with similar ones."""
    topics = [entity.name for entity in entities(door) if entity.kind in {"publisher", "subscription"}]
    similar = did_you_mean(topic, topics, "", cutoff=0.7)
    return f"no topic {topic} yet; waiting, Ctrl-C stops" + (f" ({similar})" if similar else "")


def add_list(verbs: Commands, what: str, kind: str) -> None:
    """Add the verb ``list`` for the entities of a *kind*, each called *what*."""

    def print_all(door: DoorClient, options: argparse.Namespace) -> int:
        known = {entity.name: entity.type for entity in entities(door, kind=kind)}
        for name, ros_type in known.items():
            if options.all or not is_hidden_name(name):
                print(f"{name} [{ros_type}]" if options.show_types else name)
        return 0

    command = add_verb(verbs, "list", f"list every {what}")
    command.add_argument("-t", "--show-types", action="store_true", help=f"show each {what}'s type")
    command.add_argument("-a", "--all", action="store_true", help=f"show hidden {what}s too")
    set_door_command(command, print_all, f"  homebot {what} list\n  homebot {what} list -t\n")


def definition_lines(typedefs: Sequence[TypeDef]) -> Iterator[str]:
    """Yield the fields of the first of *typedefs*, and below each those of its type, indented."""
    known = {typedef.type: typedef for typedef in typedefs}

    def lines(typedef: TypeDef, indent: str) -> Iterator[str]:
        for name, value in zip(typedef.constnames, typedef.constvalues, strict=True):
            yield f"{indent}{name}={value}"
        kinds = (typedef.fieldtypes, typedef.fieldnames, typedef.fieldarraylen)
        for kind, name, length in zip(*kinds, strict=True):
            yield f"{indent}{kind}{'' if length < 0 else f'[{length or str()}]'} {name}"
            if kind in known:
                yield from lines(known[kind], f"{indent}  ")

    return lines(typedefs[0], "")


class Schema:
    """A message type and the types in it, from rosapi."""

    def __init__(self, typedefs: Sequence[TypeDef]) -> None:
        self._types = {typedef.type: _fields(typedef) for typedef in typedefs}
        self._root = typedefs[0].type if typedefs else ""

    def readable(self, message: dict[str, object]) -> dict[str, object]:
        """Return *message* with its base64-encoded bytes as text if possible, else as a list."""
        return self._message(message, self._root)

    def _message(self, message: dict[str, object], ros_type: str) -> dict[str, object]:
        fields = self._types.get(ros_type, {})
        return {name: self._value(value, fields.get(name, "")) for name, value in message.items()}

    def _value(self, value: object, ros_type: str) -> object:
        if ros_type == "uint8[]" and isinstance(value, str):
            return _readable_bytes(value)
        if isinstance(value, list):
            return [self._value(item, ros_type.removesuffix("[]")) for item in value]
        return self._message(value, ros_type.removesuffix("[]")) if isinstance(value, dict) else value


def typedefs(door: DoorClient, service: str, ros_type: str) -> Sequence[TypeDef]:
    """Return *ros_type* and the types in it, as a *service* of ``/rosapi`` describes them."""
    return cast("Sequence[TypeDef]", JsonMessage(door.call(service, {"type": ros_type})).typedefs)


def _fields(typedef: TypeDef) -> dict[str, str]:
    """Return the type of each field by name; array types end in ``[]``."""
    kinds = (typedef.fieldnames, typedef.fieldtypes, typedef.fieldarraylen)
    return {name: kind if length < 0 else f"{kind}[]" for name, kind, length in zip(*kinds, strict=True)}


def _readable_bytes(text: str) -> str | list[int]:
    try:
        value = base64.b64decode(text, validate=True)
    except binascii.Error:
        return text
    try:
        return value.decode()
    except UnicodeDecodeError:
        return list(value)
