"""Base class of messages, the types of their fields, and the type of a service.

Plain ``bool``, ``int``, ``float``, ``str`` and ``bytes`` mean ``bool``, ``int64``, ``float64``, ``string`` and
``uint8[]``; the annotated types here are the others. ``tuple[T, ...]`` is ``T[]``, bounded by ``Field(max_length=n)``
(``T[<=n]``), of fixed length if ``min_length`` is the same number (``T[n]``). ``Int8Array`` and the other numeric
arrays are sequences of machine numbers, and can be built from any sequence.

Modules of messages omit ``from __future__ import annotations``: pydantic evaluates the annotations of a class, and of
its base classes, when the class is created, and textual ones have to be compiled first (15 µs a field).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Generic, Self, TypeVar

from pydantic import BaseModel, ConfigDict, Field, GetCoreSchemaHandler
from pydantic_core import CoreSchema

from homebot.errors import UsageError
from homebot.messages.numeric_array import RosArray


@dataclass(frozen=True, slots=True)
class RosType:
    """Marks an annotated Python type with its ROS primitive."""

    name: str


Int8 = Annotated[int, RosType("int8"), Field(ge=-(2**7), lt=2**7)]
Int16 = Annotated[int, RosType("int16"), Field(ge=-(2**15), lt=2**15)]
Int32 = Annotated[int, RosType("int32"), Field(ge=-(2**31), lt=2**31)]
Int64 = Annotated[int, RosType("int64"), Field(ge=-(2**63), lt=2**63)]
UInt8 = Annotated[int, RosType("uint8"), Field(ge=0, lt=2**8)]
UInt16 = Annotated[int, RosType("uint16"), Field(ge=0, lt=2**16)]
UInt32 = Annotated[int, RosType("uint32"), Field(ge=0, lt=2**32)]
UInt64 = Annotated[int, RosType("uint64"), Field(ge=0, lt=2**64)]
Byte = Annotated[int, RosType("byte"), Field(ge=0, lt=2**8)]
Char = Annotated[int, RosType("char"), Field(ge=0, lt=2**8)]
Float32 = Annotated[float, RosType("float32")]
Float64 = Annotated[float, RosType("float64")]
Int8Array = Annotated[Sequence[int], RosArray("int8", Int8)]
Int16Array = Annotated[Sequence[int], RosArray("int16", Int16)]
Int32Array = Annotated[Sequence[int], RosArray("int32", Int32)]
Int64Array = Annotated[Sequence[int], RosArray("int64", Int64)]
UInt16Array = Annotated[Sequence[int], RosArray("uint16", UInt16)]
UInt32Array = Annotated[Sequence[int], RosArray("uint32", UInt32)]
UInt64Array = Annotated[Sequence[int], RosArray("uint64", UInt64)]
ByteArray = Annotated[Sequence[int], RosArray("byte", Byte)]
CharArray = Annotated[Sequence[int], RosArray("char", Char)]
Float32Array = Annotated[Sequence[float], RosArray("float32", Float32)]
Float64Array = Annotated[Sequence[float], RosArray("float64", Float64)]


def _bound_integers(schema: Any) -> None:
    """Give every unbounded integer in *schema* the bounds of ``int64``.

    Defined before its user, because pydantic calls it while the class below is being created.
    """
    if isinstance(schema, list):
        for part in schema:
            _bound_integers(part)
    if not isinstance(schema, dict):
        return
    if schema.get("type") == "int":
        if schema.keys().isdisjoint({"ge", "gt"}):
            schema["ge"] = -(2**63)
        if schema.keys().isdisjoint({"le", "lt"}):
            schema["lt"] = 2**63
    for part in ("schema", "items_schema"):
        _bound_integers(schema.get(part))
    for field in schema.get("fields", {}).values():
        _bound_integers(field)


_ALL_FIELDS: dict[type[BaseModel], set[str]] = {}
"""The field names of each message type; here because pydantic 2.9 does not support private class variables."""


class Message(BaseModel):  # noqa: PLW1641 - pydantic makes the hash of a frozen model
    """A frozen value with exact ROS field types, validated once when it is created and then passed by reference.

    Attributes:
        ros_type: The full ROS name of the type, ``package/msg/Name``; given as ``class Name(Message, ros_type=…)``, by
            default ``<top-level package>/msg/<class>``.
        key_field: Name of the field that identifies an instance on a topic (a DDS key), ``field.field`` in a nested
            message; a topic of a type with a key field keeps its history per key.

    Raises:
        UsageError: The key field of a class does not exist.
    """

    model_config = ConfigDict(
        frozen=True,
        extra="forbid",
        strict=True,
        allow_inf_nan=True,
        defer_build=True,  # most programs use few of the types that they import
        protected_namespaces=(),  # ROS has field names such as `model_instances`
    )

    ros_type: ClassVar[str]
    key_field: ClassVar[str | None] = None

    @classmethod
    def of_checked(cls, /, **fields: object) -> Self:  # without the slash each name would be compared with `cls`
        """Return the message with *fields*, which must be complete, without validation.

        Only for values from messages, which are already validated. It takes a third of the time, and half the memory
        for a small message, which matters when a whole house is published. Hot code looks it up once: an attribute of a
        message class costs as much as a call.
        """
        message = _new(cls)
        _set_fields(message, fields)
        return message

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return the message with the fields of *update*, without validation, like pydantic.

        A shallow copy takes a quarter of pydantic's time, which also copies the set of given fields.
        """
        if deep:
            return super().model_copy(update=update, deep=True)
        message = _new(type(self))
        _set_fields(message, {**self.__dict__, **(update or {})})
        return message

    def slimmed(self) -> Self:
        """Return this message without the set of given fields, which takes up to 2 kB."""
        _set_names(self, _ALL_FIELDS[type(self)])
        return self

    def json_form(self) -> object:
        """Return the JSON value of this message inside another one, if that is not the object of its fields."""
        return self

    if not TYPE_CHECKING:  # a type checker would accept any attribute

        def __getattr__(self, name: str) -> object:
            """Return pydantic's attributes for a message from :meth:`of_checked`, which sets none."""
            if name == "__pydantic_fields_set__":
                return _ALL_FIELDS[type(self)]
            if name in _NONE_OF_MESSAGES:
                return None
            return super().__getattr__(name)

    def __eq__(self, other: object) -> bool:
        """Return whether *other* has the same type and equal fields, which is all that a message contains."""
        if type(self) is not type(other):
            return NotImplemented
        return self.__dict__ == other.__dict__

    def __init_subclass__(cls, ros_type: str | None = None, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        if ros_type is not None:
            cls.ros_type = ros_type
        elif "ros_type" not in cls.__dict__:
            cls.ros_type = f"{cls.__module__.partition('.')[0]}/msg/{cls.__name__}"

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: object) -> None:
        """Check the key field of a new class; called by pydantic."""
        super().__pydantic_init_subclass__(**kwargs)
        if cls.key_field is not None and cls.key_field.partition(".")[0] not in cls.model_fields:
            raise UsageError(f"{cls.__name__} has no field {cls.key_field!r} to use as its key")
        _ALL_FIELDS[cls] = set(cls.model_fields)

    @classmethod
    def __get_pydantic_core_schema__(cls, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Limit plain ``int`` to the range of ``int64``; called by pydantic."""
        schema = handler(source)
        _bound_integers(handler.resolve_ref_schema(schema))
        return schema


# These bypass pydantic's check that nothing is set.
_new = object.__new__
_set_fields = vars(BaseModel)["__dict__"].__set__
_set_names = vars(BaseModel)["__pydantic_fields_set__"].__set__

_NONE_OF_MESSAGES = frozenset({"__pydantic_extra__", "__pydantic_private__"})

RequestT = TypeVar("RequestT", bound=Message)

ResponseT = TypeVar("ResponseT")


@dataclass(frozen=True)
class ServiceType(Generic[RequestT, ResponseT]):
    """The request and response messages of a service, like the generated ``Trigger.Request`` etc. of ROS."""

    ros_type: str
    Request: type[RequestT]
    Response: type[ResponseT]

    def answer_type(self) -> type[ResponseT]:
        """Return the type of in-process answers."""
        return self.Response


@dataclass(frozen=True)
class LocalServiceType(ServiceType[RequestT, Any]):
    """Service type with another type of in-process answers: its response defines ``answer_type`` and ``of``."""

    def answer_type(self) -> type[Any]:
        """As for :class:`ServiceType`."""
        return self.Response.answer_type()  # type: ignore[no-any-return]


class ServiceAnswer(Message):
    """Base class of answers of services that may fail, with the reason in words.

    Attributes:
        message: The reason of a failure, as text.
    """

    success: bool
    message: str = ""
