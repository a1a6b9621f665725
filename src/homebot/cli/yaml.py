"""Messages as YAML, as ``ros2 topic echo`` prints them, and files in YAML that a person gives to a command."""

from __future__ import annotations

import json
import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path

from homebot.errors import UsageError

__all__ = ["read_yaml", "to_yaml"]

_PLAIN = re.compile(r"[A-Za-z_/][A-Za-z0-9_/.+@ -]*(?<! )")
_RESERVED = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}


def read_yaml(file: str) -> object:
    """Return the content of *file*, ``-`` for the standard input.

    Raises:
        UsageError: It cannot be read, is no YAML, or has aliases, by which a short file may be of any size.
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
