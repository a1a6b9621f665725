"""A file in YAML that a person gives to a command."""

from __future__ import annotations

import sys
from pathlib import Path

import yaml

from homebot.errors import UsageError

__all__ = ["read_yaml"]


def read_yaml(file: str) -> object:
    """Return the content of *file*, ``-`` for the standard input.

    Raises:
        UsageError: It cannot be read, is no YAML, or has aliases, by which a short file may be of any size.
    """
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
