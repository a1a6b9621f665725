"""The entities of the graph and the fields of its messages, as ``/rosapi`` lists them.

Also the command that ``homebot topic``, ``service`` and ``action`` share: ``list``.
"""

from __future__ import annotations

import argparse
import base64
import binascii
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Final, cast

from homebot.cli.arguments import Commands, add_verb
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.yaml import message, type_or_message
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import PeerError
from homebot.names import absolute_name
from homebot.names import is_hidden as is_hidden_name
from homebot.support.similar import did_you_mean

if TYPE_CHECKING:
    from homebot.bridges.rosapi.endpoints import EndpointDetails
    from homebot.bridges.rosapi.services import TypeDef

_ENDS: Final = {
    "topic": ("publisher", "subscription"),
    "service": ("service",),
    "action": ("action server", "action client"),
}


def entities(
    door: DoorClient, *, kind: str = "", name: str = "", node: str = "", elsewhere: bool = False
) -> list[EndpointDetails]:
    """Return the entities of the graph, or those *elsewhere*, sorted by name; an empty text means any."""
    asked = {"kind": kind, "name": name, "node": node, **({"elsewhere": True} if elsewhere else {})}
    found = JsonMessage(door.call("/rosapi/endpoints", asked))
    return cast("list[EndpointDetails]", found.endpoints)


def is_hidden(entity: EndpointDetails) -> bool:
    """Return whether *entity* is shown only on request."""
    return is_hidden_name(entity.name)


def topic_type(door: DoorClient, topic: str) -> str:
    """Return the type of *topic*; empty if there is no such topic."""
    return str(door.call("/rosapi/topic_type", {"topic": topic})["type"])


def no_such_topic(door: DoorClient, topic: str) -> PeerError:
    """Return the error that there is no *topic*; its message names similar ones."""
    return not_found("topic", topic, _topics(door))


def not_yet(door: DoorClient, topic: str) -> str:
    """Return the line that says that the missing *topic* is awaited, and names similar ones."""
    similar = did_you_mean(topic, _topics(door), "", cutoff=0.7)
    return f"homebot: no topic {topic} yet; waiting, Ctrl-C stops" + (f" ({similar})" if similar else "")


def not_found(kind: str, name: str, known: Iterable[str]) -> PeerError:
    """Return the error that there is no *kind* called *name*; its message names similar ones of the *known*."""
    return PeerError(f"there is no {kind} {name}; {did_you_mean(name, known, f'`homebot {kind} list` lists all')}")


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


def message_schema(door: DoorClient, ros_type: str) -> Schema:
    """Request the schema of the message type *ros_type*."""
    return _schema(door, "/rosapi/message_details", ros_type)


def response_schema(door: DoorClient, ros_type: str) -> Schema:
    """Request the schema of the response of the service type *ros_type*."""
    return _schema(door, "/rosapi/service_response_details", ros_type)


def _schema(door: DoorClient, service: str, ros_type: str) -> Schema:
    return Schema(typedefs(door, service, ros_type))


def typedefs(door: DoorClient, service: str, ros_type: str) -> Sequence[TypeDef]:
    """Return *ros_type* and the types in it, as a *service* of ``/rosapi`` describes them."""
    return cast("Sequence[TypeDef]", JsonMessage(door.call(service, {"type": ros_type})).typedefs)


def _fields(typedef: TypeDef) -> dict[str, str]:
    """Return the type of each field by name; array types end in ``[]``."""
    kinds = (typedef.fieldnames, typedef.fieldtypes, typedef.fieldarraylen)
    return {name: kind if length < 0 else f"{kind}[]" for name, kind, length in zip(*kinds, strict=True)}


def _topics(door: DoorClient) -> list[str]:
    return [entity.name for entity in entities(door) if entity.kind in {"publisher", "subscription"}]


def _readable_bytes(text: str) -> str | list[int]:
    try:
        value = base64.b64decode(text, validate=True)
    except binascii.Error:
        return text
    try:
        return value.decode()
    except UnicodeDecodeError:
        return list(value)


def add_list_verb(verbs: Commands, kind: str) -> None:
    """Add the command that lists the entities of *kind*, a key of the table above."""
    command = add_verb(verbs, "list", f"list every {kind}")
    command.add_argument("-t", "--show-types", action="store_true", help=f"show each {kind}'s type")
    set_door_command(command, _list, f"  homebot {kind} list\n  homebot {kind} list -t\n")
    command.set_defaults(kind=kind)
    command.add_argument("-a", "--all", action="store_true", help=f"show hidden {kind}s too")


def add_value_arguments(command: argparse.ArgumentParser, kind: str, value: str) -> None:
    """Add the name of a *kind*, and the type and fields of a *value* for it."""
    command.add_argument(kind, metavar=kind.upper(), help=f"name of the {kind}")
    command.add_argument(
        "type", metavar="TYPE", nargs="?", default="", type=type_or_message, help="expected type (default: any)"
    )
    command.add_argument(
        value, metavar=value.upper(), nargs="?", default="{}", type=message, help="as JSON or as {field: value}"
    )


def type_of(door: DoorClient, kind: str, name: str) -> str:
    """Return the type of the *kind* called *name*.

    Raises:
        PeerError: There is none; names similar ones.
    """
    known = _types(door, kind, show_hidden=True)
    full_name = absolute_name(name)
    if full_name not in known:
        raise not_found(kind, full_name, known)
    return known[full_name]


def check_type(kind: str, name: str, ros_type: str, expected: str) -> None:
    """Check that *ros_type* is the *expected* one, if any, with or without its kind.

    Raises:
        PeerError: It is a different type.
    """
    if expected and _short(expected) != _short(ros_type):
        raise PeerError(f"{kind} {name} is a {ros_type}, not a {expected}")


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    known, places = _types(door, options.kind, show_hidden=options.all), _types_elsewhere(door, options.kind)
    for name, ros_type in sorted({**{name: found for name, (found, _) in places.items()}, **known}.items()):
        if options.all or not is_hidden_name(name):
            place = f"  (at {', '.join(places[name][1])})" if name in places else ""
            print(f"{name} [{ros_type}]{place}" if options.show_types else f"{name}{place}")
    return 0


def _types(door: DoorClient, kind: str, *, show_hidden: bool) -> dict[str, str]:
    ends = [
        entity for entity in entities(door) if entity.kind in _ENDS[kind] and (show_hidden or not is_hidden(entity))
    ]
    return {end.name: end.type for end in ends}


def _types_elsewhere(door: DoorClient, kind: str) -> dict[str, tuple[str, list[str]]]:
    """Return what robots and other machines have: by its name the type, and the nodes that have it."""
    found: dict[str, tuple[str, list[str]]] = {}
    for entity in entities(door, kind="publisher" if kind == "topic" else "service", elsewhere=True):
        action, _, part = entity.name.partition("/_action/")
        if kind != "action":
            found.setdefault(entity.name, (entity.type, []))[1].append(entity.node)
        elif part == "send_goal":
            found.setdefault(action, (entity.type.removesuffix("_SendGoal"), []))[1].append(entity.node)
    return found


def _short(ros_type: str) -> str:
    package, _, name = ros_type.partition("/")
    return f"{package}/{name.rpartition('/')[2]}"
