"""YAML: values typed by people, messages in the style of ``ros2 topic echo``, and files given to a command."""

import argparse
import json
import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TypeAlias, cast

from homebot.errors import UsageError, WireError
from homebot.support.strict_json import parse_strict

__all__ = ["FlowValue", "message", "parse_flow", "read_yaml", "to_yaml", "type_or_message"]

_PLAIN = re.compile(r"[A-Za-z_/][A-Za-z0-9_/.+@ -]*(?<! )")
_RESERVED = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}

FlowValue: TypeAlias = "bool | int | float | str | list[FlowValue] | dict[str, FlowValue] | None"
_MAX_NESTING = 100
_SPACE = re.compile(r"\s*")
_QUOTED = re.compile(r"\"(?:[^\"\\]|\\.)*\"|'(?:[^']|'')*'", re.DOTALL)
_PLAIN_KEY = re.compile(r"[^,\[\]{}\"':]+(?=\s*:)")
_PLAIN_VALUE = re.compile(r"(?:[^,\[\]{}:]|:(?!\s))+")
_FIELD = re.compile(r"\s*\w+:\s")
_INTEGER = re.compile(r"[-+]?[0-9]+")
_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
_CONSTANTS = {"true": True, "false": False, "null": None, "~": None, ".nan": float("nan"), ".inf": float("inf")}


def read_yaml(file: str) -> object:
    """Return the content of *file*, or of standard input for ``-``.

    Raises:
        UsageError: It cannot be read, is not YAML, or has aliases, which can expand a short file to any size.
    """
    import yaml  # noqa: PLC0415 - few commands read a file

    try:
        text = sys.stdin.read() if file == "-" else Path(file).read_text("utf-8")
        if any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text)):
            raise UsageError(f"{file} has an alias (*NAME): write the value itself there")
        return yaml.safe_load(text)
    except yaml.MarkedYAMLError as exc:
        line = f"line {exc.problem_mark.line + 1}: " if exc.problem_mark else ""
        raise UsageError(f"{file} cannot be read: {line}{exc.problem}") from exc
    except (OSError, ValueError, RecursionError, yaml.YAMLError) as exc:
        raise UsageError(f"{file} cannot be read: {getattr(exc, 'strerror', None) or exc}") from exc


def to_yaml(value: object) -> str:
    """Return *value*, made of dicts, lists and scalars, as YAML that ends in a line break."""
    if isinstance(value, dict | list) and value:
        return "".join(f"{line}\n" for line in _block(value))
    return f"{_scalar(value)}\n"


def _block(value: dict[str, object] | list[object]) -> Iterator[str]:
    if isinstance(value, dict):
        for name, item in value.items():
            yield from _entry(f"{name}:", item)
        return
    if all(isinstance(item, int | float) for item in value):
        yield f"[{', '.join(_scalar(item) for item in value)}]"
        return
    for item in value:
        if isinstance(item, dict | list) and item:
            first, *rest = _block(item)
            yield f"- {first}"
            yield from (f"  {line}" for line in rest)
        else:
            yield f"- {_scalar(item)}"


def _entry(name: str, item: object) -> Iterator[str]:
    if not isinstance(item, dict | list) or not item:
        yield f"{name} {_scalar(item)}"
        return
    lines = list(_block(item))
    if isinstance(item, list) and len(lines) == 1 and lines[0].startswith("["):
        yield f"{name} {lines[0]}"
        return
    yield name
    yield from (f"  {line}" for line in lines)


def _scalar(value: object) -> str:
    if isinstance(value, str):
        is_plain = _PLAIN.fullmatch(value) is not None and value.lower() not in _RESERVED
        return value if is_plain else json.dumps(value, ensure_ascii=not value.isprintable())
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    return json.dumps(value)


def parse_flow(text: str) -> FlowValue:
    """Parse *text* as a value; words other than numbers, ``true``, ``false`` and ``null`` are texts.

    Raises:
        WireError: It is not a value; the message contains the position of the error.
    """
    try:
        value = cast("FlowValue", parse_strict(text))
    except (ValueError, RecursionError):
        return _Flow(text).parse()
    return value


def message(text: str) -> dict[str, object]:
    """Parse *text* as fields in JSON or YAML flow style; the outer braces may be omitted."""
    try:
        value = parse_flow(f"{{{text}}}" if _FIELD.match(text) else text)
    except WireError as exc:
        raise argparse.ArgumentTypeError(str(exc)) from exc
    if not isinstance(value, dict):
        raise argparse.ArgumentTypeError(f"give the fields as {{name: value, ...}}, got {text!r}")
    return dict(value)


def type_or_message(text: str) -> str | dict[str, object]:
    """Return *text* unchanged, or parsed as fields if it begins with a brace or a field."""
    return message(text) if text.lstrip().startswith("{") or _FIELD.match(text) else text


class _Flow:
    """A reader that scans the text once, from left to right."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._at = 0
        self._depth = 0

    def parse(self) -> FlowValue:
        value = self._value()
        self._skip_space()
        if self._at < len(self._text):
            raise self._error("nothing more was expected")
        return value

    def _value(self) -> FlowValue:
        self._skip_space()
        following = self._text[self._at : self._at + 1]
        if following == "{":
            return self._mapping()
        if following == "[":
            return [self._value() for _ in self._places("]")]
        if following and following in "\"'":
            return self._quoted()
        return self._plain()

    def _mapping(self) -> FlowValue:
        fields: dict[str, FlowValue] = {}
        for _ in self._places("}"):
            key = self._key()
            if key in fields:
                raise self._error(f"the field {key[:60]!r} occurs twice")
            self._expect(":")
            fields[key] = self._value()
        return fields

    def _places(self, end: str) -> Iterator[None]:
        """Yield at the beginning of each item of a collection, until its *end*."""
        self._depth += 1
        if self._depth > _MAX_NESTING:
            raise self._error(f"nested more than {_MAX_NESTING} deep")
        self._at += 1
        is_first = True
        while not self._take(end):
            if not is_first:
                self._expect(",")
            is_first = False
            yield
        self._depth -= 1

    def _key(self) -> str:
        self._skip_space()
        if self._text[self._at : self._at + 1] in {'"', "'"}:
            return self._quoted()
        found = _PLAIN_KEY.match(self._text, self._at)
        if found is None:
            raise self._error("a field's name and a colon were expected")
        self._at = found.end()
        return found[0].strip()

    def _quoted(self) -> str:
        found = _QUOTED.match(self._text, self._at)
        if found is None:
            raise self._error("a quotation mark is not closed")
        self._at = found.end()
        if found[0].startswith("'"):
            return found[0][1:-1].replace("''", "'")
        try:
            return str(json.loads(found[0], strict=False))
        except ValueError as exc:
            raise self._error(f"a text in quotation marks is wrong: {exc}") from exc

    def _plain(self) -> FlowValue:
        found = _PLAIN_VALUE.match(self._text, self._at)
        text = found[0].strip() if found else ""
        if found is None or not text:
            raise self._error("a value was expected")
        self._at = found.end()
        if text in _CONSTANTS:
            return _CONSTANTS[text]
        if _INTEGER.fullmatch(text) and len(text) < 1000:
            return int(text)
        return float(text) if _NUMBER.fullmatch(text) else text

    def _take(self, sign: str) -> bool:
        self._skip_space()
        if self._text.startswith(sign, self._at):
            self._at += 1
            return True
        if self._at >= len(self._text):
            raise self._error(f"{sign!r} is missing")
        return False

    def _expect(self, sign: str) -> None:
        if not self._take(sign):
            raise self._error(f"{sign!r} was expected")

    def _skip_space(self) -> None:
        found = _SPACE.match(self._text, self._at)
        self._at = found.end() if found else self._at

    def _error(self, problem: str) -> WireError:
        rest = self._text[self._at : self._at + 20]
        where = f"before {rest!r}" if rest else "at its end"
        return WireError(f"cannot read {self._text[:60]!r}: {problem} {where}")
