"""The reader for all TOML files, which reports invalid values with their key."""

import os
import stat
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import TypeAlias

from homebot.errors import ConfigError
from homebot.support.file_access import open_now

TomlTable: TypeAlias = dict[str, object]

_MAX_NUMBER = 2**63
_MAX_BYTES = 4 * 1024 * 1024
_MAX_DEPTH = 64


def read_toml(path: Path, *, any_text: bool = False, may_be_cut: bool = False) -> TomlTable:
    """Return the tables of the file *path*.

    Args:
        any_text: As for :func:`parse_toml`.
        may_be_cut: Whether it may be half saved, so that digits may be missing at its end.

    Raises:
        ConfigError: It cannot be read, or as :func:`parse_toml`.
    """
    source = str(path)
    try:
        with open_now(path) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise ConfigError(source, "", "is no regular file")
            data = file.read(_MAX_BYTES + 1)
        if len(data) > _MAX_BYTES:
            raise ConfigError(source, "", f"is larger than {_MAX_BYTES // 1024**2} MiB")
        if may_be_cut and data[-1:].isdigit():
            raise ConfigError(source, "", "ends within a number; end its last line with a line break")
        text = data.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as exc:
        raise ConfigError(source, "", "cannot be read: it is not UTF-8 text") from exc
    except FileNotFoundError as exc:
        raise ConfigError(source, "", "does not exist") from exc
    except (OSError, ValueError) as exc:  # the path may contain invalid characters
        raise ConfigError(source, "", f"cannot be read: {getattr(exc, 'strerror', None) or exc}") from exc
    return parse_toml(text, source, any_text=any_text)


def parse_toml(text: str, source: str, *, any_text: bool = False) -> TomlTable:
    """Parse *text*; return its tables.

    Args:
        any_text: Whether texts may contain U+0000, for texts sent to devices.

    Raises:
        ConfigError: It is no TOML, is nested deeper than 64 levels, or holds a number of more than 64 bits or the
            character U+0000; names *source*, key and reason.
    """
    try:
        tables = tomllib.loads(text)
        _check(tables, source, "", any_text=any_text)
    except tomllib.TOMLDecodeError as exc:
        hint = (
            "; a text stands in quotes, true and false are written small"
            if str(exc).startswith("Invalid value")
            else ""
        )
        raise ConfigError(source, "", f"is invalid TOML: {exc}{hint}") from exc
    except RecursionError as exc:
        raise ConfigError(source, "", "is nested too deep") from exc
    except ConfigError:
        raise
    except ValueError as exc:  # a number of some thousand digits
        raise ConfigError(source, "", f"is invalid TOML: {str(exc).partition(';')[0]}") from exc
    return tables


def _check(value: object, source: str, key: str, left: int = _MAX_DEPTH, *, any_text: bool) -> None:
    if not left:
        raise ConfigError(source, "", "is nested too deep")
    for name, item in _items(value):
        inner = f"{key}.{name}" if key else name
        if "\0" in name:
            raise ConfigError(source, inner.replace("\0", "\\u0000"), "has the character U+0000 in its name")
        _check(item, source, inner, left - 1, any_text=any_text)
    if isinstance(value, str) and "\0" in value and not any_text:
        raise ConfigError(source, key, "contains the character U+0000, which is not allowed")
    if isinstance(value, int) and not -_MAX_NUMBER <= value < _MAX_NUMBER:
        raise ConfigError(source, key, "is a number of more than 64 bits")


def _items(value: object) -> Iterable[tuple[str, object]]:
    """Return the items of a table by their names, or of an array by their numbers; none of another value."""
    if isinstance(value, list):
        return ((str(number), item) for number, item in enumerate(value))
    return value.items() if isinstance(value, dict) else ()
