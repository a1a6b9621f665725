"""Messages as rclpy's programs know them: made empty, with fields set one by one, and arrays as lists.

Each class has a message type of homebot behind it; values are checked when a message is sent.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from pydantic import ValidationError

from homebot.errors import TypeMismatchError
from homebot.messages.action import ActionType
from homebot.messages.definition import FieldDefinition, fields_of, zero_message
from homebot.messages.json import validation_problem
from homebot.messages.message import Message, ServiceType

__all__ = [
    "ActionInterface",
    "AnyAction",
    "AnyMessage",
    "AnyService",
    "InterfaceMessage",
    "ServiceInterface",
    "from_message",
    "message_class",
    "to_action",
    "to_message",
    "to_message_type",
    "to_service",
]


class _InterfaceClass(type):
    """Makes the constants of a message type readable on its class."""

    message_type: type[Message]

    def __getattr__(cls, name: str) -> object:
        if name.startswith("_") or "message_type" not in cls.__dict__:
            raise AttributeError(name)
        return getattr(cls.message_type, name)


class InterfaceMessage(metaclass=_InterfaceClass):
    """A message with fields that can be set; those not given have ROS's defaults: 0, False, empty.

    Attributes:
        message_type: The message type of homebot.

    Raises:
        AttributeError: A field is unknown, when it is given or set.
    """

    __slots__ = ()
    message_type: ClassVar[type[Message]]

    def __init__(self, **fields: object) -> None:
        zero = _zero(self.message_type)
        for name in self.message_type.model_fields:
            setattr(self, name, fields.pop(name) if name in fields else _changeable(getattr(zero, name)))
        for name, value in fields.items():
            setattr(self, name, value)

    def __eq__(self, other: object) -> bool:
        """Return whether *other* is of the same type and has equal fields."""
        if not isinstance(other, InterfaceMessage) or self.message_type is not other.message_type:
            return NotImplemented
        return all(getattr(self, name) == getattr(other, name) for name in self.message_type.model_fields)

    __hash__ = None  # type: ignore[assignment]  # it changes

    def __repr__(self) -> str:
        fields = ", ".join(f"{name}={getattr(self, name)!r}" for name in self.message_type.model_fields)
        return f"{self.message_type.ros_type.replace('/', '.')}({fields})"

    if TYPE_CHECKING:  # the fields are those of the message type

        def __getattr__(self, name: str) -> Any: ...

        def __setattr__(self, name: str, value: object) -> None: ...


@dataclass(frozen=True)
class ServiceInterface:
    """The request and response of a service."""

    service_type: ServiceType[Any, Any]
    Request: type[InterfaceMessage]
    Response: type[InterfaceMessage]


@dataclass(frozen=True)
class ActionInterface:
    """The goal, result and feedback of an action."""

    action_type: ActionType[Any, Any, Any]
    Goal: type[InterfaceMessage]
    Result: type[InterfaceMessage]
    Feedback: type[InterfaceMessage]


AnyMessage: TypeAlias = type[InterfaceMessage] | type[Message]
AnyService: TypeAlias = ServiceInterface | ServiceType[Any, Any]
AnyAction: TypeAlias = ActionInterface | ActionType[Any, Any, Any]


def message_class(message_type: type[Message]) -> type[InterfaceMessage]:
    """Return the class of messages of *message_type* with fields that can be set."""
    return _message_class(message_type)


@lru_cache(maxsize=1024)
def _message_class(message_type: Any) -> type[InterfaceMessage]:
    name = message_type.ros_type.rpartition("/")[2]
    body = {
        "__slots__": tuple(message_type.model_fields),
        "__doc__": message_type.__doc__,
        "message_type": message_type,
    }
    return _InterfaceClass(name, (InterfaceMessage,), body)  # type: ignore[return-value]  # a metaclass's result


@lru_cache(maxsize=1024)
def to_service(service: AnyService) -> ServiceInterface:
    """Return *service* with messages whose fields can be set."""
    if isinstance(service, ServiceInterface):
        return service
    return ServiceInterface(service, message_class(service.Request), message_class(service.Response))


@lru_cache(maxsize=1024)
def to_action(action: AnyAction) -> ActionInterface:
    """Return *action* with messages whose fields can be set."""
    if isinstance(action, ActionInterface):
        return action
    return ActionInterface(
        action, message_class(action.Goal), message_class(action.Result), message_class(action.Feedback)
    )


def to_message_type(kind: AnyMessage) -> type[Message]:
    """Return the message type of homebot that *kind* is, or has behind it."""
    return kind if issubclass(kind, Message) else kind.message_type


def to_message(value: object, message_type: type[Message]) -> Message:
    """Return *value* as a message of homebot.

    Raises:
        TypeMismatchError: It is of another type, or a field has a wrong value; names the field and the value.
    """
    known = value.message_type if isinstance(value, InterfaceMessage) else type(value)
    if known is not message_type:
        found = known.ros_type if issubclass(known, Message) else known.__name__
        raise TypeMismatchError(f"expected a {message_type.ros_type}, got a {found}")
    if isinstance(value, Message):
        return value
    fields = {field.name: _checked(field, getattr(value, field.name)) for field in fields_of(message_type)}
    try:
        return message_type.model_validate(fields)
    except ValidationError as exc:
        raise TypeMismatchError(f"not a {message_type.ros_type}: {validation_problem(exc)}") from exc


def from_message(message: Message) -> InterfaceMessage:
    """Return *message* with fields that can be set."""
    values = {name: _changeable(getattr(message, name)) for name in type(message).model_fields}
    return message_class(type(message))(**values)


_zero = lru_cache(maxsize=1024)(zero_message)


def _checked(field: FieldDefinition, value: object) -> object:
    if field.is_bytes:
        return bytes(value) if isinstance(value, bytes | bytearray | memoryview | list | tuple) else value
    if field.is_array and not isinstance(value, str | bytes) and hasattr(value, "__iter__"):
        return tuple(_element(field, item) for item in value)
    return _element(field, value)


def _element(field: FieldDefinition, value: object) -> object:
    if field.message is not None and isinstance(value, InterfaceMessage):
        return to_message(value, field.message)
    if field.choices is not None and isinstance(value, str) and value in tuple(field.choices):
        return field.choices(value)
    return value


def _changeable(value: object) -> object:
    if isinstance(value, Message):
        return from_message(value)
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return [_changeable(item) for item in value]
    return value
