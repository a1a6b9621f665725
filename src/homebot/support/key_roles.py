"""The roles of keys of tables for secrets, as the models that read the tables declare them. Pure.

A :class:`KeyRole` in the metadata of a field's type comes first; then a ``SecretStr`` of pydantic is a secret, and a
text or a path has the role that its name says.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from enum import Enum, auto
from pathlib import Path
from types import UnionType
from typing import TYPE_CHECKING, Annotated, Any, Final, NamedTuple, Union, get_args, get_origin

from pydantic import BaseModel, SecretBytes, SecretStr

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo


class KeyRole(Enum):
    """The role of a key for secrets."""

    PUBLIC = auto()
    SECRET = auto()
    SECRET_FILE = auto()
    """It names a file with a secret."""
    SECRET_NAME = auto()
    """It names a secret that is kept elsewhere, such as in an environment variable."""
    PEER = auto()
    """It says where the secrets beside it are sent."""


class DeclaredKey(NamedTuple):
    """A value of a table that was read.

    Attributes:
        table: The path of the innermost table that has a model.
        key: The key in it.
        value: The value, as text; of a list each element has a row.
    """

    table: tuple[str, ...]
    key: str
    role: KeyRole
    value: str


_SECRET_WORDS: Final = frozenset(
    {
        *("code", "pin", "password", "passwd", "passphrase", "passcode", "psk", "token", "secret", "credential"),
        *("credentials", "key", "apikey", "authorization"),
    }
)
_LOGIN: Final = re.compile(r"(?<=://)[^\s/@\"]+@")
"""User and password in a URL, also in JSON."""

_PASSWORD: Final = re.compile(r"://[^\s/@:]*:[^\s/@]+@")

_tables: ContextVar[list[tuple[str, type[BaseModel], object]] | None] = ContextVar("_tables", default=None)


def is_secret_name(name: str) -> bool:
    """Return whether the field *name* is named like a secret, such as ``pin`` or ``wifi_password``."""
    plain = "".join(character if character.isalnum() else "_" for character in name.casefold())
    return any(part in _SECRET_WORDS for part in plain.split("_"))


def role_by_name(name: str) -> KeyRole:
    """Return the role that the *name* of a key says: ``alarm_code``, ``token_file``, ``api_key_env``."""
    if not is_secret_name(name):
        return KeyRole.PUBLIC
    ends = {"file": KeyRole.SECRET_FILE, "env": KeyRole.SECRET_NAME}
    return ends.get(name.rpartition("_")[2], KeyRole.SECRET)


def without_login(text: str, shown: str) -> str:
    """Return *text* with *shown* in place of users and passwords in URLs, with the sign behind them."""
    return _LOGIN.sub(shown, text)


def has_password(text: str) -> bool:
    """Return whether *text* has a URL with a password."""
    return _PASSWORD.search(text) is not None


def role_of(key: str, field: FieldInfo) -> KeyRole:
    """Return the role of *key*, which the model of its table declares as *field*."""
    parts = [*field.metadata, *_parts(field.annotation)]
    if roles := [part for part in parts if isinstance(part, KeyRole)]:
        return roles[0]
    if SecretStr in parts or SecretBytes in parts:
        return KeyRole.SECRET
    return role_by_name(key) if str in parts or Path in parts else KeyRole.PUBLIC


def role_at(model: type[BaseModel], path: tuple[int | str, ...]) -> KeyRole:
    """Return the role of the value at *path* in a table of *model*: that of the innermost key that has one."""
    kinds, found = [model], KeyRole.PUBLIC
    for part in path:
        fields = [one for kind in kinds for key, one in _fields(kind) if key == part]
        kinds = [one for field in fields for one in _models(field.annotation)] or kinds
        found = next((role_of(str(part), field) for field in fields), found)
    return found


def declared_keys(model: type[BaseModel], table: object, path: tuple[str, ...] = ()) -> Iterator[DeclaredKey]:
    """Yield the values of *table*, which need not be valid, as *model* declares them; none of keys it does not have."""
    fields = dict(_fields(model))
    for key, value in table.items() if isinstance(table, Mapping) else ():
        if (field := fields.get(key)) is not None:
            row = DeclaredKey(path, key, role_of(key, field), "")
            yield from dict.fromkeys(_rows(field.annotation, value, row, (*path, key)))


@contextmanager
def tables_read() -> Iterator[list[tuple[str, type[BaseModel], object]]]:
    """Yield a list to which each table that is read inside the block is added: its key, its model and itself."""
    tables = list[tuple[str, type[BaseModel], object]]()
    token = _tables.set(tables)
    try:
        yield tables
    finally:
        _tables.reset(token)


def note_table(key: str, model: type[BaseModel], table: object) -> None:
    """Tell :func:`tables_read` that *table* is read by *model*, before it is validated."""
    if (tables := _tables.get()) is not None:
        tables.append((key, model, table))


def _fields(model: type[BaseModel]) -> Iterator[tuple[str, FieldInfo]]:
    return ((field.alias or name, field) for name, field in model.model_fields.items())


def _parts(kind: Any) -> Iterator[Any]:
    """Yield the types of which *kind* consists, and their metadata."""
    yield kind
    if get_origin(kind) is Annotated:
        yield from kind.__metadata__
    for part in get_args(kind):
        yield from _parts(part)


def _models(kind: Any) -> Iterator[type[BaseModel]]:
    return (part for part in _parts(kind) if isinstance(part, type) and issubclass(part, BaseModel))


def _rows(kind: Any, value: object, row: DeclaredKey, path: tuple[str, ...]) -> Iterator[DeclaredKey]:
    origin, parts = get_origin(kind), get_args(kind)
    if origin is Annotated:
        yield from _rows(parts[0], value, row, path)
    elif origin in {Union, UnionType}:
        for part in parts:
            yield from _rows(part, value, row, path)
    elif isinstance(value, Mapping):
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            yield from declared_keys(kind, value, path)
        for name, one in value.items() if parts else ():
            yield from _rows(parts[-1], one, row, (*path, name))
    elif isinstance(value, list | tuple):
        for number, one in enumerate(value):
            yield from _rows(parts[0] if parts else object, one, row, (*path, str(number)))
    else:
        yield row._replace(value=str(value))
