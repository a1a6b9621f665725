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

_PLAIN = re.compile(r"[A-Za-z_/][A-Za-z0-9_/.+@ -]*(?<! )")
_RESERVED = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}

FlowValue: TypeAlias = "bool | int | float | str | list[FlowValue] | dict[str, FlowValue] | None"
_FIELD = re.compile(r"\s*\w+:\s")


def read_yaml(file: str) -> object:
    """Return the content of *file*, or of standard input for ``-``.

    Raises:
        UsageError: It cannot be read, is not YAML, or has aliases, which can expand a short file to any size.
    """
    try:
        text = sys.stdin.read() if file == "-" else Path(file).read_text("utf-8")
    except (OSError, ValueError) as exc:
        raise UsageError(f"{file} cannot be read: {getattr(exc, 'strerror', None) or exc}") from exc
    try:
        return _load(text)
    except WireError as exc:
        raise UsageError(f"{file} cannot be read: {exc}") from exc


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
    """Parse *text* as a value of JSON or of YAML 1.2; words other than its numbers and constants are texts.

    Raises:
        WireError: It is not a value; the message contains the position of the error.
    """
    try:
        return cast("FlowValue", parse_strict(text))
    except (ValueError, RecursionError):
        pass
    if not text.strip():
        raise WireError("cannot read '': a value was expected")
    try:
        return cast("FlowValue", _load(text))
    except WireError as exc:
        raise WireError(f"cannot read {text[:60]!r}: {exc}") from exc


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


def _load(text: str) -> object:
    from homebot.cli.yaml_loader import load_yaml  # noqa: PLC0415 - few commands read any

    return load_yaml(text)
