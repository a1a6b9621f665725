"""The contract of a feature: data alone, so that listing all features loads nothing of them (docs/features.md).

A feature of homebot itself is a folder in :mod:`homebot.features` whose package has the object ``FEATURE``; that of
another package is at an entry point ``homebot.features``. The core loops over features, and names none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Final, NamedTuple, Protocol

from homebot.errors import PluginError
from homebot.plugins import entry_points_of_others, error_text
from homebot.rights import OfferedService

GROUP: Final = "homebot.features"

_FOLDER: Final = Path(__file__).with_name("features")


class Verb(NamedTuple):
    """A command of the command line.

    Attributes:
        purpose: Its use, in a line.
        add_arguments: The function that adds its arguments to a parser, as ``module:name``.
        after: The command that it follows in the help; by default it is one of the last.
    """

    purpose: str
    add_arguments: str
    after: str = ""


class RunFacts(Protocol):
    """The facts of a run on which a feature may depend: those of :class:`~homebot.feature_context.FeatureContext`."""

    @property
    def keeps_data(self) -> bool:
        """True if the run keeps data of its own accord: in files, or in memory of a simulated house."""

    @property
    def is_rehearsal(self) -> bool:
        """True if nothing is sent to devices, as in a dry run and a replay."""

    @property
    def table(self) -> Callable[[str], Any]:
        """A function that returns a table of a feature by its key; None if the configuration has none."""


class FeatureTable(NamedTuple):
    """A table of the configuration, or an array of tables.

    Attributes:
        reader: The function that checks it and returns its values, as ``module:name``; it is called with the
            :class:`~homebot.config.Config`, if that has the table. With a *plugin* it returns the tables of gateways or
            apps by their names instead; it is called with the table and with the other ones of that section.
        is_array: Whether it is ``[[KEY]]``, of which a wrong element is left out, and not ``[KEY]``.
        is_on_page: Whether the page may change it: it runs no program, and has no rights.
        is_live: Whether a reload applies changes, and a replay has it too; otherwise they wait for a restart.
        plugin: The class that it configures, as ``module:Class``; empty for none.
        was: The class in recordings of earlier versions; empty for the same.
        section: The tables that those of the plug-in join: ``gateways`` or ``apps``.
        check: Checks each app of the plug-in beside its settings; called with its name, its table and the
            :class:`~homebot.config.Config`.
        implied_by: The attribute of classes of gateways for which the plug-in runs without a table; empty for none.
    """

    reader: str
    is_array: bool = False
    is_on_page: bool = False
    is_live: bool = False
    plugin: str = ""
    was: str = ""
    section: str = ""
    check: str = ""
    implied_by: str = ""


class RunOption(NamedTuple):
    """An option of ``homebot run`` with a value.

    Attributes:
        metavar: The value, in the help.
        purpose: Its use, in a line.
        opens: A context manager around the run, as ``module:name``, which is called with the value, and gives the
            :class:`~homebot.feature_context.RunObserver` of the run.
    """

    metavar: str
    purpose: str
    opens: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Feature:
    """A feature. Texts of the form ``module:name`` are loaded when they are needed; empty ones are left out.

    Attributes:
        name: The name of its node, which no app may have.
        server: Returns an object with ``serve(name)``, which creates the service or action *name*; it is called with
            the node and a :class:`~homebot.feature_context.FeatureContext` when one is first used.
        services: Its services and actions.
        stores: Names of stores of work to finish after a restart: with anything in one, *server* is called at once.
        keeps_apps: A word such as ``routine`` for the apps that its server, an
            :class:`~homebot.feature_context.AppKeeper`, keeps beside those of the configuration; empty for none.
        runs: An async function that runs all the time, from two seconds after the start; called with the context.
        over_zenoh: An async function that runs while there is a session of ``[ros]`` with robots and other machines,
            which opens before gateways start; called with an :class:`~homebot.runtime.session_keeper.OpenSession`.
        is_wanted: Returns whether *runs* is to run, and its modules to be loaded.
        files: Its data files beside that of the directory, which backups have, with their schemas as ``module:name``.
        tables: Its tables of the configuration, by key.
        verbs: Its commands of the command line, by name.
        run_options: Its options of ``homebot run``, by name without dashes.
        messages: Modules with its messages, for clients.
        routes: Its routes of the HTTP API, a tuple of :class:`~homebot.bridges.home_api.routes.ApiRoute`.
        tools: A function that adds its tools to the server for agents, with the client of the HTTP API.
        explains: The function for ``homebot why NAME`` if NAME is no device; called with the client and the options.
        adds_to_why: Yields lines for ``homebot why NAME``, of a device or robot; called with the client and NAME.
        adds_to_why_not: Yields lines for ``homebot why-not``; called with the client and the id of the device.
        checks: A function that returns a :class:`~homebot.devices.findings.DeviceCheck` for each question of the doctor
            about devices; called with the names of gateways that do not work. Its node offers ``~/health`` for others.
        causes: How ``why`` and the journal word a trigger of its kinds, with ``{text}`` for the trigger's text.
    """

    name: str
    server: str = ""
    services: tuple[OfferedService, ...] = ()
    stores: tuple[str, ...] = ()
    keeps_apps: str = ""
    runs: str = ""
    over_zenoh: str = ""
    is_wanted: Callable[[RunFacts], bool] = lambda _: True
    files: Mapping[str, str] = field(default_factory=dict)
    tables: Mapping[str, FeatureTable] = field(default_factory=dict)
    verbs: Mapping[str, Verb] = field(default_factory=dict)
    run_options: Mapping[str, RunOption] = field(default_factory=dict)
    messages: tuple[str, ...] = ()
    routes: str = ""
    tools: str = ""
    explains: str = ""
    adds_to_why: str = ""
    adds_to_why_not: str = ""
    checks: str = ""
    causes: Mapping[str, str] = field(default_factory=dict)

    def offers(self) -> Iterator[str]:
        """Yield the names that no other feature may offer."""
        yield f"the node {self.name}"
        yield from (f"the service {service.name}" for service in self.services)
        yield from (f"the file {name}" for name in self.files)
        yield from (f"the table {key}" for key in self.tables)
        yield from (f"the command {verb}" for verb in self.verbs)
        yield from (f"the option --{option}" for option in self.run_options)
        yield from (f"the cause {kind}" for kind in self.causes)


class FoundFeatures(NamedTuple):
    """The features of this installation.

    Attributes:
        features: Those that can be used, by name.
        problems: Why some of other packages cannot, by name: homebot runs without them.
    """

    features: Mapping[str, Feature]
    problems: Mapping[str, str]


@cache
def find_features() -> FoundFeatures:
    """Find all features, each of which is a few lines of data.

    Raises:
        PluginError: A feature of homebot itself is wrong.
    """
    features: dict[str, Feature] = {}
    taken: dict[str, str] = {}
    for name in sorted(file.parent.name for file in _FOLDER.glob("*/__init__.py")):
        _add(load(f"homebot.features.{name}:FEATURE"), name, features, taken)
    problems: dict[str, str] = {}
    for point in entry_points_of_others(GROUP):
        try:
            _add(load(point.value), point.name, features, taken)
        except PluginError as exc:
            problems[point.name] = str(exc)
    return FoundFeatures(features, problems)


def _add(feature: object, name: str, found: dict[str, Feature], taken: dict[str, str]) -> None:
    if not isinstance(feature, Feature) or feature.name != name:
        raise PluginError(name, f"is {feature!r:.200}, not a Feature of that name")
    for offer in feature.offers():
        if offer in taken:
            raise PluginError(name, f"offers {offer}, as the feature {taken[offer]} does")
    taken.update(dict.fromkeys(feature.offers(), name))
    found[name] = feature


def all_features() -> tuple[Feature, ...]:
    """Return the features that can be used."""
    return tuple(find_features().features.values())


def load(path: str) -> Any:
    """Return the object that a feature names as ``module:name``.

    Raises:
        PluginError: It cannot be imported.
    """
    module, _, name = path.partition(":")
    try:
        return getattr(import_module(module), name)
    except (Exception, SystemExit) as exc:
        raise PluginError(path, f"cannot be loaded: {error_text(exc)}") from exc


@cache
def feature_tables() -> Mapping[str, FeatureTable]:
    """Return the tables of all features, by key."""
    return {key: table for feature in all_features() for key, table in feature.tables.items()}


@cache
def plugin_tables() -> Mapping[str, str]:
    """Return the keys of the tables that configure plug-ins, by the class of the plug-in, as ``module:Class``."""
    return {table.plugin: key for key, table in feature_tables().items() if table.plugin}


def cause_words(kind: str) -> str:
    """Return how a trigger of *kind* is worded; as its text if no feature knows the kind."""
    return next((feature.causes[kind] for feature in all_features() if kind in feature.causes), "{text}")


@cache
def feature_services() -> Mapping[str, OfferedService]:
    """Return the services and actions of all features, by name."""
    return {service.name: service for feature in all_features() for service in feature.services}
