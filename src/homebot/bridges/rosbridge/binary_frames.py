"""The frames of rosbridge v2 with messages in CBOR, for clients that ask for ``cbor`` or ``cbor-raw``. Pure.

Source: RobotWebTools rosbridge_suite, ROSBRIDGE_PROTOCOL.md, sections 3.1.3 and 3.1.4; RFC 8746 for arrays of numbers.
"""

from homebot.conventions.cbor import cbor_head, encode_cbor
from homebot.messages.builtin_interfaces import Time
from homebot.messages.cdr import message_to_cdr
from homebot.messages.definition import FieldDefinition, fields_of
from homebot.messages.message import Message
from homebot.messages.numeric_array import NumericArray

_BYTES, _ARRAY, _MAP, _TAG = 2, 4, 5, 6
_TYPED_ARRAYS = {  # tag, layout; as in the original, all little-endian
    "int8": (72, "b"),
    "uint16": (69, "H"),
    "int16": (77, "h"),
    "uint32": (70, "I"),
    "int32": (78, "i"),
    "uint64": (71, "Q"),
    "int64": (79, "q"),
    "float32": (85, "f"),
    "float64": (86, "d"),
}


def publish_cbor(topic: str, message: Message, lost: int = 0) -> bytes:
    """Return the frame with *message* in CBOR; ``lost`` (an extension) is the number dropped before it."""
    return _frame(topic, _message(message), lost)


def publish_cbor_raw(topic: str, message: Message, received: Time, lost: int = 0) -> bytes:
    """Return the frame with *message* in CDR, as ROS 2 encodes it, and the time when it was *received*."""
    raw = message_to_cdr(message)
    parts = {"secs": encode_cbor(received.sec), "nsecs": encode_cbor(received.nanosec), "bytes": _bytes(raw)}
    return _frame(topic, _map(parts), lost)


def _frame(topic: str, msg: bytes, lost: int) -> bytes:
    parts = {"op": encode_cbor("publish"), "topic": encode_cbor(topic), "msg": msg}
    return _map(parts | {"lost": encode_cbor(lost)} if lost else parts)


def _message(message: Message) -> bytes:
    return _map({field.name: _value(field, field.value_in(message)) for field in fields_of(type(message))})


def _value(field: FieldDefinition, value: object) -> bytes:
    if isinstance(value, bytes):
        return _bytes(value)
    if isinstance(value, Message):
        return _message(value)
    if not isinstance(value, tuple | NumericArray):
        return encode_cbor(value)
    if (typed := _TYPED_ARRAYS.get(field.ros_type)) is not None:
        tag, layout = typed
        return cbor_head(_TAG, tag) + _bytes(NumericArray(layout, value).to_bytes(layout))
    return cbor_head(_ARRAY, len(value)) + b"".join(_value(field, item) for item in value)


def _bytes(value: bytes) -> bytes:
    return cbor_head(_BYTES, len(value)) + value


def _map(parts: dict[str, bytes]) -> bytes:
    return cbor_head(_MAP, len(parts)) + b"".join(encode_cbor(name) + value for name, value in parts.items())
