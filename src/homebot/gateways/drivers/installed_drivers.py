"""The usable drivers of an mDNS gateway, by service type."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from pydantic import ValidationError

from homebot.config import in_folder
from homebot.conventions.dns_sd import full_type
from homebot.errors import PluginError, UsageError
from homebot.gateways.drivers import Driver, DriverSettings
from homebot.plugins import load_plugin, plugin_names

__all__ = ["DRIVERS", "UsableDriver", "find_drivers"]

DRIVERS = "homebot.drivers"


@dataclass(frozen=True, slots=True)
class UsableDriver:
    """A driver that can be used."""

    name: str
    kind: type[Driver]
    settings: DriverSettings


def find_drivers(
    tables: Mapping[str, Mapping[str, object]], folder: Path
) -> tuple[Mapping[str, UsableDriver], tuple[str, ...]]:
    """Load all installed drivers, and those in the configuration, with paths relative to *folder*.

    Returns:
        The usable drivers by service type, and the reasons why others cannot be used, in words. Of two for one type,
        the one named in the configuration counts, or else the first by name.

    Raises:
        UsageError: A driver with a table cannot be used, or its table is invalid.
    """
    by_type: dict[str, UsableDriver] = {}
    problems = []
    for name in (*tables, *(one for one in plugin_names(DRIVERS) if one not in tables)):
        try:
            driver = _load(name, tables.get(name, {}), folder)
        except UsageError as exc:
            if name in tables:
                raise UsageError(f"drivers.{name}: {exc}") from exc
            problems.append(f"the driver {name} is not used: {exc}")
            continue
        for service_type in driver.kind.service_types:
            by_type.setdefault(full_type(service_type), driver)
    return by_type, tuple(problems)


def _load(name: str, table: Mapping[str, object], folder: Path) -> UsableDriver:
    kind = load_plugin(DRIVERS, name)
    if not issubclass(kind, Driver):
        raise PluginError(name, f"{kind.__name__} is not a Driver; derive it from {Driver.__module__}")
    try:
        settings = kind.Settings.model_validate(table, context=in_folder(folder))
    except ValidationError as exc:
        first = exc.errors(include_url=False, include_input=False)[0]
        raise UsageError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}") from exc
    kind.check(settings)
    return UsableDriver(name, kind, settings)
