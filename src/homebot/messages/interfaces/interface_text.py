"""Parser of the text of ``.msg``, ``.srv`` and ``.action`` files, and builder of their classes. Pure."""

import ast
import re
from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from types import GenericAlias
from typing import Annotated, Any, ClassVar, Final

from pydantic import Field

from homebot.errors import UsageError
from homebot.messages import message as fields
from homebot.messages.action import ActionType, message_class
from homebot.messages.definition import TEXTS, FieldDefinition
from homebot.messages.message import Message, RosType, ServiceType
from homebot.messages.numeric_array import LAYOUTS

Interface = type[Message] | ServiceType[Any, Any] | ActionType[Any, Any, Any]

FindMessage = Callable[[str], type[Message]]

_NUMBERS: Final = {
    name.lower(): (getattr(fields, name), getattr(fields, f"{name}Array", bytes))
    for name in vars(fields)
    if name.lower() in LAYOUTS
}
"""The field type and the array type for each numeric type; that of ``uint8`` is bytes."""

KINDS: Final = {"msg": ("",), "srv": ("_Request", "_Response"), "action": ("_Goal", "_Result", "_Feedback")}
"""The messages of each kind of interface, by the suffixes of their names."""

_PRIMITIVES: Final = {*LAYOUTS, *TEXTS, "bool"}
_NAME = re.compile(r"(?P<package>[a-z][a-z0-9_]*)/(?:(?P<kind>msg|srv|action)/)?(?P<name>[A-Z][A-Za-z0-9]*)")
_LINE = re.compile(
    r"(?P<base>[A-Za-z][A-Za-z0-9_/]*)(?:<=(?P<longest>\d+))?(?P<array>\[(?P<bound><=)?(?P<count>\d*)\])?"
    r"\s+(?P<name>[A-Za-z][A-Za-z0-9_]*)\s*(?:(?P<constant>=)\s*)?(?P<value>.*)"
)
_FIELD_NAME = re.compile(r"[a-z][a-z0-9]*(?:_[a-z0-9]+)*")
_CONSTANT_NAME = re.compile(r"[A-Z][A-Z0-9]*(?:_[A-Z0-9]+)*")
_MARK = re.compile("[#\"']")
_QUOTED: Final = {mark: re.compile(rf"{mark}[^{mark}\\]*+(?:\\.[^{mark}\\]*+)*+{mark}") for mark in "\"'"}
_ITEM = re.compile(r"""("(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*'|[^,\s][^,]*)\s*(?:,|$)""")
_SECTION = re.compile(r"^={80}\nMSG: (\S+)\n", re.MULTILINE)
_PART = re.compile(r"^---[^\S\n]*$", re.MULTILINE)
_TRUTHS: Final = {"true": True, "1": True, "false": False, "0": False}


@dataclass(frozen=True, slots=True)
class ParsedMessage:
    """The ordered field definitions of a message, its declared defaults and its constants."""

    ros_type: str
    fields: dict[str, FieldDefinition] = field(default_factory=dict)
    defaults: dict[str, object] = field(default_factory=dict)
    constants: dict[str, object] = field(default_factory=dict)


def interface_key(ros_type: str, kind: str = "msg") -> str:
    """Return ``package/kind/Name`` for *ros_type*, which may omit the *kind*; empty if it is not such a name."""
    named = _NAME.fullmatch(ros_type)
    if named is None or named["kind"] not in {None, kind} or "__" in ros_type:
        return ""
    return f"{named['package']}/{kind}/{named['name']}"


def split_definitions(ros_type: str, text: str) -> dict[str, str]:
    """Return the texts of *ros_type* and of the messages after it, by key; *text* is like ``definition_text``."""
    own, *rest = _SECTION.split(text.replace("\r\n", "\n"))
    texts = {ros_type: own}
    for name, section in zip(rest[::2], rest[1::2], strict=True):
        key = interface_key(name)
        if not key or key in texts:
            raise UsageError(f"{ros_type}: {name[:100]!r} is defined twice, or is not a message name")
        texts[key] = section
    return texts


def parse_interface(key: str, text: str) -> tuple[ParsedMessage, ...]:
    """Return the messages of the interface *key* (``package/kind/Name``) with the *text*.

    Raises:
        UsageError: A line is invalid; the message names the type, the line and the problem.
    """
    kind = key.split("/")[1]
    parts, suffixes = _PART.split(text.replace("\r\n", "\n")), KINDS[kind]
    if len(parts) != len(suffixes):
        raise UsageError(f"{key}: a .{kind} file has {len(suffixes)} parts with a line --- between them")
    return tuple(_parse_message(f"{key}{suffix}", part) for suffix, part in zip(suffixes, parts, strict=True))


def _parse_message(ros_type: str, text: str) -> ParsedMessage:
    message = ParsedMessage(ros_type)
    for number, line in enumerate(text.split("\n"), start=1):
        if stripped := _without_comment(line).strip():
            try:
                _add_line(message, stripped)
            except (ValueError, SyntaxError) as exc:
                raise UsageError(f"{ros_type}: line {number}: {exc}, got {stripped[:100]!r}") from exc
    return message


def _without_comment(line: str) -> str:
    """Return *line* up to the first ``#`` outside quoted text."""
    at, lone = 0, ""
    while (match := _MARK.search(line, at)) is not None:
        mark, at = match[0], match.end()
        if mark == "#":
            return line[: match.start()]
        if mark in lone:
            continue
        quoted = _QUOTED[mark].match(line, match.start())
        if quoted is None:
            lone += mark  # no later one is closed either
        else:
            at = quoted.end()
    return line


def _add_line(message: ParsedMessage, line: str) -> None:
    parts = _LINE.fullmatch(line)
    if parts is None:
        raise ValueError("a line is TYPE NAME, TYPE NAME DEFAULT or TYPE NAME=VALUE")
    base, name, value = parts["base"], parts["name"], parts["value"]
    if name in message.fields or name in message.constants:
        raise ValueError(f"there are two {name!r}")
    if parts["longest"] and base not in TEXTS:
        raise ValueError("only a string has a bound before its brackets")
    if parts["constant"]:
        if parts["array"] or parts["base"] not in _PRIMITIVES or not _CONSTANT_NAME.fullmatch(parts["name"]):
            raise ValueError("a constant is of one primitive, in capitals")
        message.constants[name] = _parse_value(parts["base"], parts["value"])
        return
    if not _FIELD_NAME.fullmatch(name):
        raise ValueError("a field has small letters, digits and single underscores")
    definition = _field(message.ros_type.partition("/")[0], parts)
    message.fields[name] = definition
    if value:
        message.defaults[name] = _parse_default(definition, value)


def _field(package: str, parts: re.Match[str]) -> FieldDefinition:
    base = parts["base"] if parts["base"] in _PRIMITIVES else _nested_key(package, parts["base"])
    count = int(parts["count"]) if parts["count"] else None
    if (parts["bound"] and count is None) or count == 0:
        raise ValueError("the length of an array is at least 1")
    size, bound = (None, count) if parts["bound"] else (count, None)
    longest = int(parts["longest"]) if parts["longest"] else None
    return FieldDefinition(parts["name"], base, is_array=bool(parts["array"]), size=size, bound=bound, longest=longest)


def _nested_key(package: str, base: str) -> str:
    key = interface_key(base if "/" in base else f"{package}/{base}")
    if not key:
        raise ValueError(f"{base!r} is not a type; known are {', '.join(sorted(_PRIMITIVES))}, and package/Name")
    return key


def _parse_default(of: FieldDefinition, text: str) -> object:
    if of.ros_type not in _PRIMITIVES:
        raise ValueError("only a primitive has a default")
    if not of.is_array:
        return _parse_value(of.ros_type, text)
    if not (text.startswith("[") and text.endswith("]")):
        raise ValueError("the default of an array is [VALUE, …]")
    values = tuple(_parse_value(of.ros_type, item.strip()) for item in _ITEM.findall(text[1:-1]))
    count = len(values)
    if count != (of.size or count) or count > (of.bound or count):
        raise ValueError(f"there are {count} values")
    return bytes(values) if of.is_bytes else values


def _parse_value(base: str, text: str) -> Any:
    if base in TEXTS:
        quoted = len(text) > 1 and text[0] == text[-1] and text[0] in "\"'"
        return str(ast.literal_eval(text)) if quoted else text
    if base == "bool":
        if text.lower() not in _TRUTHS:
            raise ValueError("a bool is true or false")
        return _TRUTHS[text.lower()]
    number = float(text) if base.startswith("float") else _parse_integer(text)
    try:
        array(LAYOUTS[base], (number,))
    except OverflowError:
        raise ValueError(f"{text} is out of the range of {base}") from None
    return number


def _parse_integer(text: str) -> int:
    """Return the integer in *text*: decimal, perhaps with leading zeros, or with the prefix of another base."""
    try:
        return int(text)
    except ValueError:
        return int(text, 0)


def build_interface(key: str, parsed: Sequence[ParsedMessage], find: FindMessage) -> Interface:
    """Return the interface *key* (``package/kind/Name``) with the messages *parsed*.

    Raises:
        UsageError: A field has an invalid name or default.
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
