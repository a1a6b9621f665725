"""Tables ``[[routines]]``, each of which is an app."""

from collections.abc import Container, Mapping
from zlib import crc32

from homebot.apps.grants import without_act
from homebot.config import Config, Table, parse_settings
from homebot.errors import ConfigError
from homebot.support.folding import words_of

_MAX_APP = 100
_UNNAMED = "routine"


def apps_of_routines(routines: object, taken: Container[str]) -> dict[str, dict[str, object]]:
    """Return the tables of *routines* by the names of their apps: those of the routines in small letters.

    One without a name, or with that of another or one of *taken*, has its number in its name, and is reported with its
    values.
    """
    found: dict[str, dict[str, object]] = {}
    for number, table in enumerate(routines if isinstance(routines, list) else [routines], 1):
        fields = table if isinstance(table, dict) else {}
        app = app_of_routine(fields.get("name"))
        is_new = app and app not in taken and app not in found
        found[app if is_new else f"{app or _UNNAMED}_{number}"] = fields
    return found


def app_of_routine(name: object) -> str:
    """Return the name of the app of the routine *name*; empty if that is no name."""
    if not isinstance(name, str) or not name.strip():
        return ""
    app = "_".join(words_of(name))[:_MAX_APP]
    if not app or not app.isascii():  # names of nodes have only Latin letters
        return f"{_UNNAMED}_{crc32(name.encode()):x}"
    return app if app[0].isalpha() else f"{_UNNAMED}_{app}"


def check_routine_name(app: str, table: Mapping[str, object], source: str) -> None:
    """Check that the routine *table* has a name, which no other routine or app has.

    Args:
        app: The name of its app.

    Raises:
        ConfigError: It has none, or that of another.
    """
    name = table.get("name")
    if (expected := app_of_routine(name)) != app:
        reason = f"{name!r} is also the name of another routine or app; choose another one"
        if not expected:
            reason = f"must be a name: write [[routines]], and below it name = 'Hall light'; got {name!r}"
        raise ConfigError(source, f"routines.{app}.name", reason)


def check_routine(app: str, table: Table, config: Config) -> None:
    """Check the table of the app of a routine beside its settings.

    Raises:
        ConfigError: It has no name, or that of another; or it asks the sun, and the place of the home is unknown.
    """
    check_routine_name(app, table, config.source)
    if config.home.latitude is not None or "sun" not in repr(table).casefold():
        return
    from homebot.features.routines.settings import RoutineSettings  # noqa: PLC0415 - few ask the sun

    settings = parse_settings(RoutineSettings, without_act(table), config.source, f"routines.{app}")
    if asking := settings.asking_the_sun():
        reason = f"{asking[0]!r} needs the place of the home: set latitude and longitude in the table [home]"
        raise ConfigError(config.source, f"routines.{app}", reason)
