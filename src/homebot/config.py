"""The configuration file: read once, checked, and handed down in parts.

::

    [home]
    name = "home425"

    [gateways.mqtt]                  # one table a gateway; class = "module:Class" where it is no plug-in
    url = "mqtt://192.168.1.10"
    root = "home425"

    [apps.light_service]             # one table an app

    [door]                           # where tools reach this homebot

    [discovery]

What stands in the table of a gateway or an app is that plug-in's own business: :func:`parse_settings` checks it with
the plug-in's model.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, TypeAlias, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError, ValidationInfo
from pydantic_core import PydanticSerializationError, to_json

from homebot.errors import ConfigError, InvalidNameError, UsageError
from homebot.file_access import readable_by_others, why_not_private, why_not_trusted
from homebot.logger import get_logger
from homebot.names import validate_node_name
from homebot.toml_file import TomlTable, read_toml

__all__ = [
    "Config",
    "FilePath",
    "HomeSettings",
    "Table",
    "check_secret_file",
    "load_config",
    "parse_config",
    "parse_settings",
    "read_secret",
]

Table: TypeAlias = TomlTable

READABLE = "config.secret_readable"

_log = get_logger()
_HERE = Path()
_FOLDER = "folder"
_LONGEST_SECRET = 65_536
_LONGEST_SHOWN = 200


def _in_folder(path: Path, info: ValidationInfo) -> Path:
    folder = info.context.get(_FOLDER, _HERE) if isinstance(info.context, dict) else _HERE
    return Path(folder) / path


FilePath: TypeAlias = Annotated[Path, AfterValidator(_in_folder)]
"""The path of a file in a configuration; a relative one begins at the folder of the configuration's file."""

ModelT = TypeVar("ModelT", bound=BaseModel)


class HomeSettings(BaseModel):
    """The table ``[home]``.

    Attributes:
        name: What this home is called, in logs and on the web page.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str = Field(default="home", min_length=1)


class Config(BaseModel):
    """The configuration of a homebot, as in ``homebot.toml``.

    Attributes:
        home: The table ``[home]``.
        gateways: The tables ``[gateways.NAME]``, by name.
        apps: The tables ``[apps.NAME]``, by name.
        door: The address at which rosbridge clients reach this homebot; empty for the default.
        discovery: The table ``[discovery]``: how long devices are kept.
        source: The file, or another source of the values, for error messages.
        folder: The folder that relative paths start from: that of the file.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    home: HomeSettings = HomeSettings()
    gateways: dict[str, Table] = Field(default_factory=dict)
    apps: dict[str, Table] = Field(default_factory=dict)
    door: Table = Field(default_factory=dict)
    discovery: Table = Field(default_factory=dict)
    source: str = Field(default="configuration", exclude=True)
    folder: Path = Field(default=_HERE, exclude=True)


def load_config(path: Path) -> Config:
    """Read the TOML file *path*.

    Raises:
        ConfigError: It cannot be read, is invalid TOML, may be changed by other users, or has an unknown key or an
            invalid value; the message names file, key and reason.
    """
    source = str(path)
    tables = read_toml(path)
    if problem := why_not_trusted(path):
        raise ConfigError(source, "", f"names the code that runs, so others must not be able to change it: {problem}")
    for name in ("source", "folder"):
        if name in tables:
            raise ConfigError(source, name, "is unknown; known are home, gateways, apps, door and discovery")
    return parse_config(tables, source, path.parent)


def parse_config(tables: Mapping[str, object], source: str, folder: Path = _HERE) -> Config:
    """Return the configuration in *tables*, which are as in the TOML file.

    Args:
        tables: The tables.
        source: The file, or another source of the tables, for error messages.
        folder: The folder that relative paths start from.

    Raises:
        ConfigError: A key is unknown or a value invalid; the message names *source*, the key and the reason.
    """
    config = parse_settings(Config, {**tables, "source": source, "folder": str(folder)}, source, "")
    for section, names in (("gateways", config.gateways), ("apps", config.apps)):
        for name in names:
            try:
                validate_node_name(name)
            except InvalidNameError as exc:
                raise ConfigError(source, f"{section}.{name}", str(exc)) from exc
    return config


def parse_settings(
    model: type[ModelT], table: Mapping[str, object], source: str, key: str, folder: Path = _HERE
) -> ModelT:
    """Return *table* checked by *model*.

    Args:
        model: What the table must look like.
        table: The table; a ``class`` in it is passed over, it chose the model.
        source: The file, for messages.
        key: The table's dotted path, for messages.
        folder: Where the paths in it begin that are of the type :data:`FilePath`.

    Raises:
        ConfigError: The first thing that is wrong: an unknown key, a wrong type, a value that may not be.
    """
    try:
        text = to_json({name: value for name, value in table.items() if name != "class"}, inf_nan_mode="constants")
        return model.model_validate_json(text, strict=True, context={_FOLDER: folder})
    except ValidationError as exc:
        first = exc.errors(include_url=False, include_context=False)[0]
        path = ".".join(part for part in (key, *(str(part) for part in first["loc"])) if part)
        reason = _reason(_model_at(model, first["loc"][:-1]), first["type"], first["msg"])
        is_secret = any(word in path.lower() for word in _SECRET_KEYS)
        shown = "" if is_secret or first["type"] in _COMPLETE_ERRORS else f", got {_shortened(first.get('input'))}"
        # The cause is left out: it would show the value of a secret.
        raise ConfigError(source, path, f"{reason}{shown}") from None
    except PydanticSerializationError:
        raise ConfigError(source, key, "is nested too deep") from None


def read_secret(path: Path) -> str:
    """Return the first line of the file *path*, without what ends it.

    Where others can read it as well, a warning is logged.

    Raises:
        UsageError: The file cannot be read, others can write it, or its first line is empty; never holds the secret.
    """
    try:
        with path.open(encoding="utf-8") as file:
            check_secret_file(path, os.fstat(file.fileno()))
            secret = file.readline(_LONGEST_SECRET).partition("\n")[0].removesuffix("\r")
    except (OSError, ValueError) as exc:
        raise UsageError(f"{path} cannot be read: {_unreadable(exc)}") from exc
    if not secret:
        raise UsageError(f"the first line of {path} is empty")
    return secret


def check_secret_file(path: Path, found: os.stat_result) -> None:
    """Refuse the file *path*, which is *found* so, where others can write it; warn where others can read it.

    Raises:
        UsageError: Others can write it.
    """
    if problem := why_not_private(path, found):
        raise UsageError(problem)
    if warning := readable_by_others(path, found):
        _log.warning(READABLE, message=warning, file=str(path))


_SECRET_KEYS = ("password", "passwd", "passphrase", "token", "url", "secret", "key", "credential", "pin")
_COMPLETE_ERRORS = {"extra_forbidden", "missing", "value_error"}


def _unreadable(error: OSError | ValueError) -> str:
    if isinstance(error, OSError):
        return error.strerror or str(error)
    return "it is not UTF-8 text" if isinstance(error, UnicodeDecodeError) else str(error)


def _shortened(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}…"


def _model_at(model: type[BaseModel], path: tuple[int | str, ...]) -> type[BaseModel]:
    """Return the model of the table at *path*, as far as tables are models."""
    for part in path:
        field = model.model_fields.get(str(part))
        if field is None or not isinstance(field.annotation, type) or not issubclass(field.annotation, BaseModel):
            break
        model = field.annotation
    return model


def _reason(model: type[BaseModel], kind: str, message: str) -> str:
    if kind == "extra_forbidden":
        known = ", ".join(name for name in model.model_fields if name not in {"source", "folder"})
        return f"is unknown; known are {known or 'none'}"
    if kind == "missing":
        return "is missing"
    message = message.removeprefix("Value error, ")
    is_word = message[1:2].islower()  # and not MQTT
    return f"{message[:1].lower()}{message[1:]}" if is_word else message
