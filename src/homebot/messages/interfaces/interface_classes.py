"""Builder of the classes of messages, services and actions from their parsed text."""

from collections.abc import Callable, Sequence
from types import GenericAlias
from typing import Annotated, Any, ClassVar, Final

from pydantic import Field

from homebot.errors import UsageError
from homebot.messages import message as fields
from homebot.messages.action import ActionType, message_class
from homebot.messages.definition import TEXTS, FieldDefinition
from homebot.messages.interfaces.interface_text import ParsedMessage
from homebot.messages.message import Message, RosType, ServiceType
from homebot.messages.numeric_array import LAYOUTS

__all__ = ["Interface", "build_interface", "messages_in"]

Interface = type[Message] | ServiceType[Any, Any] | ActionType[Any, Any, Any]

FindMessage = Callable[[str], type[Message]]

_NUMBERS: Final = {
    name.lower(): (getattr(fields, name), getattr(fields, f"{name}Array", bytes))
    for name in fields.__all__
    if name.lower() in LAYOUTS
}
"""The types of a field and of an array of each number; that of ``uint8`` is bytes."""


def build_interface(key: str, parsed: Sequence[ParsedMessage], find: FindMessage) -> Interface:
    """Return the interface *key* (``package/kind/Name``) with the messages *parsed*.

    Raises:
        UsageError: A field has a name or a default that it cannot have.
    """
    classes = [_build_message(message, find) for message in parsed]
    if len(classes) == 1:
        return classes[0]
    return ServiceType(key, *classes) if len(classes) == 2 else ActionType(key, *classes)


def messages_in(interface: Interface) -> tuple[type[Message], ...]:
    """Return the messages of *interface*, in the order of its kind."""
    if isinstance(interface, ServiceType):
        return interface.Request, interface.Response
    if isinstance(interface, ActionType):
        return interface.Goal, interface.Result, interface.Feedback
    return (interface,)


def _build_message(parsed: ParsedMessage, find: FindMessage) -> type[Message]:
    for name in parsed.fields:
        if hasattr(Message, name):
            raise UsageError(f"{parsed.ros_type}: messages have a {name!r} of their own; give the field another name")
    annotations: dict[str, object] = dict.fromkeys(parsed.constants, ClassVar)
    annotations |= {name: _annotation(field, find) for name, field in parsed.fields.items()}
    return message_class(parsed.ros_type, annotations, parsed.constants | parsed.defaults)


def _annotation(field: FieldDefinition, find: FindMessage) -> object:
    element = _element(field, find)
    if not field.is_array:
        return element
    sequence: Any = _NUMBERS[field.ros_type][1] if field.ros_type in _NUMBERS else GenericAlias(tuple, (element, ...))
    if field.size is not None:
        return Annotated[sequence, Field(min_length=field.size, max_length=field.size)]
    return sequence if field.bound is None else Annotated[sequence, Field(max_length=field.bound)]


def _element(field: FieldDefinition, find: FindMessage) -> object:
    if field.ros_type in _NUMBERS:
        return _NUMBERS[field.ros_type][0]
    if field.ros_type in TEXTS:
        text = Annotated[str, RosType(field.ros_type)]
        return text if field.longest is None else Annotated[text, Field(max_length=field.longest)]
    return bool if field.ros_type == "bool" else find(field.ros_type)
