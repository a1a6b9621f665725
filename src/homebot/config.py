"""The configuration file: read once, checked, and handed down in parts.

::

    [home]
    name = "home425"
    zone = "Europe/Berlin"
    [gateways.mqtt]                  # one table per gateway; class = "module:Class" if it is not a plug-in
    url = "mqtt://192.168.1.10"
    [apps.light_service]             # one table per app
    [[routines]]                     # one table per routine: when, if, do
    [[scenes]]                       # one table per scene: the values of several devices
    [people.Anna]                    # one table per person: the phones that tell who is at home
    [door]                           # where tools reach this homebot
    [discovery]
    [control]                        # how long commands wait for devices to answer
    [history]                        # how long measurements are kept
    [notify]                         # where notifications of apps and alerts are sent
    [alerts]                         # after how long people are told of what is wrong
    [places.rooms.Hall]              # rooms, and the devices in them
    floor = "Downstairs"
    [robots.rosie]                   # one table per robot: where its pose comes from
    [ros]                            # ROS interfaces of clients, besides the built-in ones

The table of a gateway or app belongs to its plug-in: :func:`parse_settings` checks it with the plug-in's model.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Final, Literal, Self, TypeAlias, TypeVar, get_args, get_origin
from zoneinfo import available_timezones

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    ValidationInfo,
    create_model,
    field_validator,
    model_validator,
)
from pydantic_core import ErrorDetails, PydanticSerializationError, to_json

from homebot.clock import read_zone
from homebot.errors import ConfigError, HomebotError, InvalidNameError, UsageError
from homebot.feature import FeatureTable, feature_tables, find_features, load
from homebot.names import validate_node_name
from homebot.support.file_access import why_not_trusted
from homebot.support.key_roles import KeyRole, has_password, note_table, role_at
from homebot.support.names import did_you_mean, unknown_key

Table: TypeAlias = dict[str, object]

_HERE = Path()
_FOLDER = "folder"
_MAX_SHOWN = 200
_MAX_ERRORS = 100

_NO_KEYS: Final = frozenset({"features", "folder", "source"})
"""The fields of a configuration that are no tables of the file."""

_GONE: Final = {"thing_directory": "is gone; programs read and command the devices at the door (docs/agents.md)"}
"""Tables that homebot had once, and the ways to what they offered."""


def folder_of(context: object) -> Path:
    """Return the base folder of relative paths from the validation *context* of a model."""
    return Path(context.get(_FOLDER, _HERE)) if isinstance(context, dict) else _HERE


def in_folder(folder: Path) -> dict[str, object]:
    """Return the validation context of models whose paths are relative to *folder*."""
    return {_FOLDER: folder}


def _in_folder(path: Path, info: ValidationInfo) -> Path:
    return folder_of(info.context) / path


FilePath: TypeAlias = Annotated[Path, AfterValidator(_in_folder)]
"""The path of a file in a configuration, relative to the folder of the configuration file."""

SecretFile: TypeAlias = Annotated[FilePath, KeyRole.SECRET_FILE]
"""The same of a file with a secret."""

SecretName: TypeAlias = Annotated[str, KeyRole.SECRET_NAME]
"""The name of a secret that is kept elsewhere, such as of an environment variable."""

PeerAddress: TypeAlias = Annotated[str, KeyRole.PEER]
"""The address, or a part of it, to which the secrets of the same table are sent."""

ModelT = TypeVar("ModelT", bound=BaseModel)
T = TypeVar("T")


UNNAMED = "home"
"""The default name of a home."""

Language: TypeAlias = Literal["en", "de", "fr", "es", "nl", "it"]


class HomeSettings(BaseModel):
    """The table ``[home]``.

    Attributes:
        name: Name of the home in logs and on the web page.
        id: The id by which its data are found, written by the first start.
        language: The language of alerts and answers, and in which routines are shown.
        zone: The time zone, by its IANA name; empty for the computer's.
        latitude: Degrees north of the equator; this and *longitude* are for the times of the sun.
        longitude: Degrees east of Greenwich.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    name: str = Field(default=UNNAMED, min_length=1)
    id: str = Field(default="", pattern=r"^([0-9a-f]{16})?$")
    language: Language = "en"
    zone: str = ""
    latitude: float | None = Field(default=None, ge=-90, le=90)
    longitude: float | None = Field(default=None, ge=-180, le=180)

    @field_validator("zone")
    @classmethod
    def _check_zone(cls, zone: str) -> str:
        try:
            if zone:
                read_zone(zone)
        except UsageError as exc:
            hint = did_you_mean(zone, available_timezones(), "write it like Europe/Berlin")
            raise ValueError(f"{exc}; {hint}") from exc
        return zone

    @model_validator(mode="after")
    def _check_place(self) -> Self:
        if (self.latitude is None) != (self.longitude is None):
            raise ValueError("give latitude and longitude, or neither of them")
        return self


AlertKey: TypeAlias = Literal[
    "smoke", "co", "gas", "leak", "alarm", "gateway", "tamper", "problem", "door", "unreachable", "silent", "battery"
]
Urgency: TypeAlias = Literal["high", "normal", "low"]
"""How people are told: at once, alone and again until seen; when it is due; once a day, all together."""

_Tables: TypeAlias = Annotated[
    tuple[object, ...], BeforeValidator(lambda value: tuple(value) if isinstance(value, list) else (value,))
]
"""Tables that are checked one by one, because a wrong one stops nothing else."""


_FeatureTables: TypeAlias = Annotated[
    dict[str, object],
    AfterValidator(
        lambda read: {key: tuple(value) if isinstance(value, list) else value for key, value in read.items()}
    ),
]
"""The tables of features, each of which its feature checks."""


WITH_COMMAND_LINE: Final = " and command line"
"""The end of the source of a file to which the command line adds."""


class Config(BaseModel):
    """The configuration of a homebot, as in ``homebot.toml``.

    Attributes:
        door: The address at which rosbridge clients reach this homebot; empty for the default.
        notify: The table ``[notify]``: where notifications of apps are sent; None to only log them.
        devices: The tables ``[devices.NAME]``: the owner's limits of readings.
        groups: The tables ``[[groups]]``: names for the devices that fit a query.
        features: The tables of features, by key: a table, or a tuple of tables.
        source: The file, or another source of the values, for error messages.
        folder: The base folder of relative paths: that of the file.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    home: HomeSettings = HomeSettings()
    gateways: dict[str, Table] = Field(default_factory=dict)
    apps: dict[str, Table] = Field(default_factory=dict)
    door: Table = Field(default_factory=dict)
    discovery: Table = Field(default_factory=dict)
    control: Table = Field(default_factory=dict)
    notify: Table | None = None
    places: Table = Field(default_factory=dict)
    devices: dict[str, Table] = Field(default_factory=dict)
    groups: _Tables = ()
    features: _FeatureTables = Field(default_factory=dict)
    robots: dict[str, Table] = Field(default_factory=dict)
    ros: Table = Field(default_factory=dict)
    source: str = Field(default="configuration", exclude=True)
    folder: Path = Field(default=_HERE, exclude=True)

    @property
    def file(self) -> Path | None:
        """The file that it was read from, also if a command line adds to it; None if it is of no file."""
        path = Path(self.source.removesuffix(WITH_COMMAND_LINE))
        return path if path.is_file() else None

    def array_of(self, key: str) -> tuple[object, ...]:
        """Return the tables ``[[KEY]]`` of a feature; None for one that was left out."""
        tables = self.features[key]
        return tables if isinstance(tables, tuple) else (tables,)


def load_config(path: Path, *, may_be_cut: bool = False) -> Config:
    """Read the TOML file *path*, which may be half saved if it *may_be_cut*.

    Raises:
        ConfigError: It cannot be read, is invalid TOML, may be changed by other users, or has an unknown key or an
            invalid value; the message names file, key and reason.
    """
    return parse_config(load_tables(path, may_be_cut=may_be_cut), str(path), path.parent)


def load_tables(path: Path, *, may_be_cut: bool = False) -> dict[str, object]:
    """Read the TOML file *path* without checking the keys in its tables.

    Raises:
        ConfigError: It cannot be read, is invalid TOML, or may be changed by other users.
    """
    source = str(path)
    from homebot.support.toml_file import read_toml  # noqa: PLC0415 - a start without a file needs none

    tables = read_toml(path, may_be_cut=may_be_cut)
    if problem := why_not_trusted(path):
        raise ConfigError(source, "", f"names the code that runs, so others must not be able to change it: {problem}")
    for name in _NO_KEYS:
        if name in tables:
            raise ConfigError(
                source,
                name,
                unknown_key(name, _known_tables()),
            )
    return tables


def parse_config(tables: Mapping[str, object], source: str, folder: Path = _HERE) -> Config:
    """Return the configuration in *tables*, which have the form of the TOML file.

    Args:
        source: The file, or another source of the tables, for error messages.
        folder: The base folder of relative paths.

    Raises:
        ConfigError: A key is unknown or a value invalid; the message names *source*, the key and the reason.
    """
    for name in _GONE.keys() & tables.keys():
        raise ConfigError(source, name, _GONE[name])
    tables = _with_features(tables, source)
    config = parse_settings(Config, {**tables, "source": source, "folder": str(folder)}, source, "")
    for section, names in (("gateways", config.gateways), ("apps", config.apps), ("robots", config.robots)):
        for name in names:
            try:
                validate_node_name(name)
            except InvalidNameError as exc:
                raise ConfigError(source, f"{section}.{name}", str(exc)) from exc
    return config


def _known_tables() -> list[str]:
    own = [key for key in Config.model_fields if key not in _NO_KEYS]
    return [*own, *feature_tables()]


def _with_features(tables: Mapping[str, object], source: str) -> dict[str, object]:
    """Return *tables* with those of features under one key, but those of plug-ins among the gateways or apps.

    If a feature of another package could not be loaded, unknown tables may be its own, and the plan leaves them out.
    """
    features: dict[str, object] = {}
    others: dict[str, object] = {}
    plugins: dict[str, FeatureTable] = {}
    for key, table in tables.items():
        row = None if key in Config.model_fields else feature_tables().get(key)
        if row is not None and row.plugin:
            plugins[key] = row
        elif row is None and (key in Config.model_fields or not find_features().problems):
            others[key] = table
        elif row is None or isinstance(table, list if row.is_array else Mapping):
            features[key] = table
        elif row.is_array:
            features[key] = [table]
        else:
            raise ConfigError(source, key, f"{_table_reason(key, is_element=False)}, got {_shorten(table)}")
    for key, row in plugins.items():
        _add_plugins(others, key, tables[key], row, source)
    return {**others, "features": features} if features else others


def _add_plugins(tables: dict[str, object], key: str, table: object, row: FeatureTable, source: str) -> None:
    """Add the *table* of a feature to *tables*, as those of gateways or apps."""
    section = tables.get(row.section, {})
    if not isinstance(section, dict):
        return  # reported with the other tables
    made: dict[str, dict[str, object]] = load(row.reader)(table, section)
    if taken := sorted(made.keys() & section.keys()):
        problem = f"is the name of the {row.section[:-1]} of [{key}]; choose another name"
        raise ConfigError(source, f"{row.section}.{taken[0]}", problem)
    tables[row.section] = section | {name: {**settings, "class": row.plugin} for name, settings in made.items()}


def parse_settings(model: type[ModelT], table: object, source: str, key: str, folder: Path = _HERE) -> ModelT:
    """Return *table*, validated by *model*.

    Args:
        table: The table; its key ``class``, which chose the model, is ignored.
        key: The table's dotted path, for messages.
        folder: The base folder of its paths of the type :data:`FilePath`.

    Raises:
        ConfigError: The first problem: an unknown key, a wrong type or an invalid value. Further problems are in its
            ``others``.
    """
    if not isinstance(table, Mapping):
        reason = _table_reason(key, is_element=key[-1:].isdigit())
        raise ConfigError(source, key, f"{reason}, got {_shorten(table)}")
    note_table(key, model, table)
    try:
        text = to_json({name: value for name, value in table.items() if name != "class"}, inf_nan_mode="constants")
        if "extra" not in model.model_config:  # a plain BaseModel ignores misspelt keys
            strict = create_model(model.__name__, __base__=model, __cls_kwargs__={"extra": "forbid"})
            strict.model_validate_json(text, strict=True, context=in_folder(folder))
        return model.model_validate_json(text, strict=True, context=in_folder(folder))
    except ValidationError as exc:
        errors = exc.errors(include_url=False, include_context=False)[:_MAX_ERRORS]
        wrong = [
            error["loc"][:-1] for error in errors
        ]  # what is left of an array with a wrong element may be too short
        errors = [error for error in errors if error["type"] != "too_short" or error["loc"] not in wrong]
        # The cause is left out: it would show the value of a secret.
        raise ConfigError.joined(_config_error(model, error, source, key) for error in errors) from None
    except PydanticSerializationError:
        raise ConfigError(source, key, "is nested too deep") from None


def read_all(readers: Iterable[Callable[[], T]]) -> list[T]:
    """Return what *readers* read.

    Raises:
        ConfigError: The first mistake, with the further ones of all readers in its ``others``.
    """
    values, mistakes = list[T](), list[ConfigError]()
    for read in readers:
        try:
            values.append(read())
        except ConfigError as exc:
            mistakes += (exc, *exc.others)
    if mistakes:
        raise ConfigError.joined(mistakes) from None
    return values


@contextmanager
def value_errors() -> Iterator[None]:
    """Convert homebot's errors in the block to ValueError, which pydantic reports for a field."""
    try:
        yield
    except HomebotError as exc:
        raise ValueError(str(exc)) from exc


_COMPLETE_ERRORS = {"extra_forbidden", "missing", "value_error"}
_TYPE_ERRORS = {
    "bool_type": "must be true or false, without quotes",
    "float_type": "must be a number, without quotes",
    "int_type": "must be a whole number, without quotes",
    "string_type": "must be a text in quotes",
    "time_parsing": "must be a time of day such as 07:00",
}
_TABLE_ERRORS = {"dict_type", "model_type"}
_ARRAY_ERRORS = {"list_type", "tuple_type"}
_PATH_OF_TABLE = re.compile(r"[\w-]+(\.[\w-]+)*", re.ASCII)


def _shorten(value: object) -> str:
    text = repr(value).lower() if isinstance(value, bool) else repr(value)
    return text if len(text) <= _MAX_SHOWN else f"{text[:_MAX_SHOWN]}…"


def _config_error(model: type[BaseModel], error: ErrorDetails, source: str, key: str) -> ConfigError:
    """Return *error*, about a value in the table *key*, with a text for people."""
    path = ".".join(part for part in (key, *(str(part) for part in error["loc"])) if part and part != "[key]")
    table = _model_at(model, error["loc"][:-1])
    if error["type"] in _TABLE_ERRORS:
        reason = _table_reason(path, is_element=isinstance(error["loc"][-1], int))
    elif error["type"] in _ARRAY_ERRORS:
        field = table.model_fields.get(str(error["loc"][-1]))
        elements = () if field is None else get_args(field.annotation)
        of_tables = any(isinstance(element, type) and issubclass(element, BaseModel) for element in elements)
        reason = f"must be an array of tables, each as in [[{path}]]" if of_tables else "must be an array"
    else:
        reason = _reason(table, error)
    got = "" if error["type"] in _COMPLETE_ERRORS else f", got {_shorten(error.get('input'))}"
    is_secret = role_at(model, error["loc"]) is KeyRole.SECRET or has_password(got)
    return ConfigError(source, path, f"{reason}{'' if is_secret else got}")


def _model_at(model: type[BaseModel], path: tuple[int | str, ...]) -> type[BaseModel]:
    """Return the model of the innermost table at *path* that has a model."""
    kind: object = model
    for part in path:
        if get_origin(kind) in {dict, tuple}:
            kind = [argument for argument in get_args(kind) if argument is not ...][-1]
        elif kind is model and (field := model.model_fields.get(str(part))) is not None:
            kind = field.annotation
        else:
            break
        kind = get_args(kind)[0] if type(None) in get_args(kind) else kind
        model = kind if isinstance(kind, type) and issubclass(kind, BaseModel) else model
    return model


def _table_reason(path: str, *, is_element: bool) -> str:
    """Return the message that the value at *path* must be a table, in TOML notation unless a key needs quotes."""
    head = f"[[{path.rpartition('.')[0]}]]" if is_element else f"[{path}]"
    return f"must be a table, as in {head}" if _PATH_OF_TABLE.fullmatch(path) else "must be a table"


def _reason(model: type[BaseModel], error: ErrorDetails) -> str:
    """Return the problems of a table of *model*, as text."""
    if error["type"] == "extra_forbidden":
        gone: Mapping[str, str] = getattr(model, "gone", {})  # of a gateway's settings
        if (became := gone.get(str(error["loc"][-1]))) is not None:
            return became
        fields = model.model_fields.items()
        known = _known_tables() if model is Config else [field.alias or name for name, field in fields]
        return unknown_key(str(error["loc"][-1]), known)
    if error["type"] == "missing":
        return "is missing"
    if error["type"] == "too_short" and error["input"] in ([], {}):
        return "is empty; it should have at least 1 item"
    if (reason := _TYPE_ERRORS.get(error["type"])) is not None:
        return reason
    message = error["msg"].removeprefix("Value error, ")
    is_word = message[1:2].islower()  # unlike MQTT
    return f"{message[:1].lower()}{message[1:]}" if is_word else message
