"""Plan of a run: the classes and settings in a configuration, checked before anything is started."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from pydantic import BaseModel, SecretStr

import homebot.control
import homebot.places
from homebot.apps import App
from homebot.apps.grants import grants_of, scope_of, without_act
from homebot.bridges.rosbridge import RosbridgeSettings
from homebot.config import UNNAMED, Config, HomeSettings, Table, parse_settings
from homebot.devices.client_rights import CurrentGrants, NodeGrants
from homebot.discovery import DirectorySettings
from homebot.errors import ConfigError, PluginError, UsageError
from homebot.feature import feature_tables, find_features, load, plugin_tables
from homebot.gateways import Gateway, HostService
from homebot.graph import Node
from homebot.places import NO_PLACES, HousePlan, Places
from homebot.plugins import check_extra, load_plugin
from homebot.runtime.rosbridge_table import read_rosbridge_settings
from homebot.support.names import did_you_mean, no_such

if TYPE_CHECKING:
    from homebot.apps.notifier import NotifySettings
    from homebot.control import ControlSettings
    from homebot.devices.robot_owners import RobotOwners
    from homebot.discovery.reading_limits import LimitsOfDevices
    from homebot.messages import Interfaces
    from homebot.messages.interfaces.settings import RosSettings
    from homebot.robots.settings import RobotSettings

GATEWAYS = "homebot.gateways"
APPS = "homebot.apps"

JOURNAL_FILE = "journal.sqlite"
"""The name of the journal's file, beside the index file."""

_DOORS = "control.presence_guard.doors"

OWN_NODES = frozenset(
    {
        "apps",
        "broker",
        "control",
        "discovery",
        "homebot",
        "robots",
        "rosapi",
        "rosbridge_websocket",
    }
)

_NONE_GIVEN: Mapping[str, type[App]] = {}

LoadPlugin: TypeAlias = "Callable[[str, str], type[Any]]"
ComponentT = TypeVar("ComponentT", Gateway, App)


@dataclass(frozen=True, slots=True)
class PlannedComponent(Generic[ComponentT]):
    """A gateway or an app to be started."""

    name: str
    kind: type[ComponentT]
    settings: BaseModel

    def offer_settings(self, node: Node) -> None:
        """Declare the settings as parameters of *node* when parameters are first requested."""
        node.parameters.declare_later(partial(self._declare, node))

    def _declare(self, node: Node) -> None:
        from homebot.runtime.settings_parameters import declare_settings  # noqa: PLC0415 - few runs are asked

        declare_settings(node, self.settings)


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """A validated configuration.

    Attributes:
        config: The configuration as it was read.
        control: The control layer's settings; None for the defaults.
        grants: The scopes of the nodes of apps; those of kept routines are added.
        interfaces: The ROS interfaces that clients may name; None for those built into homebot.
        link: The link to ROS 2 robots; None for none.
        places: The rooms and the owner's statements about devices.
        limits: The limits of readings; None for none.
        notify: The settings of notifications of apps; None to only log them.
        features: The tables of features as their readers returned them, by key.
        left_out: The mistakes of wrong apps, routines, groups, arrays of features and features of other packages, by
            their keys: they stop nothing else.
    """

    config: Config
    home: str
    home_settings: HomeSettings
    gateways: tuple[PlannedComponent[Gateway], ...]
    apps: tuple[PlannedComponent[App], ...]
    discovery: DirectorySettings
    control: ControlSettings | None
    door: RosbridgeSettings
    interfaces: Interfaces | None = None
    link: RosSettings | None = None
    places: Places = NO_PLACES
    limits: LimitsOfDevices | None = None
    grants: CurrentGrants = field(default_factory=CurrentGrants)
    robots: Mapping[str, RobotSettings] = field(default_factory=dict)
    notify: NotifySettings | None = None
    features: Mapping[str, Any] = field(default_factory=dict)
    left_out: Mapping[str, ConfigError] = field(default_factory=dict)

    @property
    def scopes(self) -> Mapping[str, Iterable[str]]:
        """The rights of apps and clients, by their keys."""
        granted = self.grants.now
        apps = {f"{granted.tables[node]} act": scope for node, scope in granted.scopes.items()}
        tokens = {f"door.tokens.{name}.scope": token.scope for name, token in self.door.tokens.items()}
        return {**apps, "door.scope": self.door.scope or (), **tokens}

    @property
    def tokens(self) -> Mapping[str, SecretStr]:
        """The tokens of clients by name."""
        return self.door.all_tokens()

    def robot_owners(self) -> RobotOwners:
        """Return the robots named in a table or in the right of a token, with their topics and frames."""
        return self.door.robot_owners({name: robot.frames for name, robot in self.robots.items()})

    def greeting(self, page: str | None, *, is_dry_run: bool) -> str:
        """Return the first line of the log, with the address of the *page*, if there is a rosbridge server."""
        home = "homebot" if self.home == UNNAMED else self.home
        if page is None:
            return f"{home} is running"
        without = "" if self.link is None else ", and there is no link of [ros]"
        note = f" (a dry run: nothing is sent to any device{without})" if is_dry_run else ""
        door = page.replace("http", "ws", 1)
        lack = "" if self.gateways else "; no device is found without a table such as [gateways.mqtt]"
        return f"{home} is running{note}; listening for rosbridge clients on {door}; its page is {page}{lack}"

    @property
    def own_gateways(self) -> tuple[str, ...]:
        """The names of the gateways of this machine."""
        return tuple(
            gateway.name
            for gateway in self.gateways
            if gateway.kind.other_machine(gateway.name, gateway.settings) is None
        )

    @property
    def other_machines(self) -> Mapping[str, Path]:
        """The machines with gateways of this house, by name, with the files of their secrets."""
        machines = (gateway.kind.other_machine(gateway.name, gateway.settings) for gateway in self.gateways)
        return dict(filter(None, machines))

    @property
    def as_other_machine(self) -> str:
        """The description of this machine if another homebot has its index and control; else empty."""
        machine = self.link.machine if self.link is not None else ""
        return machine and f"this is the machine {machine}: the homebot of {self.home} that joined it has its devices"

    @property
    def names_robots(self) -> bool:
        """True if a table or a token's right names a robot."""
        return bool(self.robots or self.door.robots())


def make_plan(config: Config, given: Mapping[str, type[App]] = _NONE_GIVEN) -> Plan:
    """Find every class that *config* names and check every table.

    Args:
        given: The classes of further apps, or of apps whose tables name none, by the name of the app.

    Raises:
        ConfigError: A class cannot be found, a table is wrong, or a secret cannot be read; names the file, the key and
            the reason.
    """
    whole = config.model_copy(update={"apps": config.apps | {name: config.apps.get(name, {}) for name in given}})
    config, mistakes = _without_mistakes(whole, given)
    return Plan(
        config=whole,
        left_out=mistakes,
        home=config.home.name,
        home_settings=config.home,
        gateways=_gateways(config),
        apps=tuple(planned_app(name, table, config, given.get(name)) for name, table in config.apps.items()),
        grants=CurrentGrants(
            NodeGrants(
                dict(grants_of(config)) | _grants_left(whole, whole.apps.keys() - config.apps.keys()),
                {f"/{name}": _in_words(name, table) for name, table in whole.apps.items()},
            )
        ),
        **{name: read(config) for name, read in _TABLES.items()},
    )


def _grants_left(config: Config, names: Iterable[str]) -> dict[str, tuple[str, ...]]:
    """Return the grants of apps that are left out but may run since before a reload; none if they are wrong too."""
    grants: dict[str, tuple[str, ...]] = {}
    for name in names:
        try:
            scope = scope_of(_key_of(name, config.apps[name]), config.apps[name], config.source)
        except ConfigError:
            scope = ("read",)
        grants |= {} if scope is None else {f"/{name}": scope}
    return grants


def plan_errors(config: Config) -> tuple[ConfigError, ...]:
    """Return all errors that prevent :func:`make_plan` from planning *config*, table by table."""
    config, left_out = _without_mistakes(config)
    parts: list[Callable[[], object]] = [partial(read, config) for read in _TABLES.values() if read is not _features]
    parts += [partial(_feature_table, key, config) for key in config.features]
    parts += [partial(_gateway, name, table, config) for name, table in config.gateways.items()]
    parts += [partial(planned_app, name, table, config) for name, table in config.apps.items()]
    errors: list[ConfigError] = []
    for part in parts:
        try:
            part()
        except ConfigError as exc:
            errors += (exc, *exc.others)
    if not errors:
        try:
            _gateways(config)
        except ConfigError as exc:
            errors.append(exc)
    return (*errors, *(error for first in left_out.values() for error in (first, *first.others)))


def _without_mistakes(
    config: Config, given: Mapping[str, type[App]] = _NONE_GIVEN
) -> tuple[Config, Mapping[str, ConfigError]]:
    broken = {
        f"features.{name}": ConfigError(config.source, f"features.{name}", f"is left out: {problem}")
        for name, problem in find_features().problems.items()
    }
    apps = dict(config.apps)
    for name, table in config.apps.items():
        if name in given or _table_of(table):
            continue
        try:
            planned_app(name, table, config)
        except ConfigError as exc:
            from homebot.config_lines import located  # noqa: PLC0415 - after a mistake alone

            broken[f"apps.{name}"] = located(exc)
            del apps[name]
    config = config.model_copy(update={"apps": apps})
    planned = {
        _key_of(name, table): partial(planned_app, name, table, config)
        for name, table in config.apps.items()
        if _table_of(table)
    }
    if not (config.groups or config.features or planned):
        return config, broken
    from homebot.runtime.left_out import without_mistakes  # noqa: PLC0415 - many homes have none of these

    rows = feature_tables()
    arrays = {key: partial(_feature_table, key) for key in config.features if key not in rows or rows[key].is_array}
    config, mistakes = without_mistakes(config, planned, {"groups": _groups, **arrays})
    return config, broken | mistakes


def _table_of(table: Table) -> str:
    """Return the key of the array of a feature that the app *table* is from; empty for one of ``[apps]``."""
    return plugin_tables().get(str(table.get("class")), "")


def _key_of(name: str, table: Table) -> str:
    return f"{_table_of(table) or 'apps'}.{name}"


def _in_words(name: str, table: Table) -> str:
    key = _table_of(table)
    return f"in [[{key}]] {table['name']!r}:" if key and "name" in table else f"[apps.{name}]"


def _gateways(config: Config) -> tuple[PlannedComponent[Gateway], ...]:
    """Return the gateways of *config*, with those of features that they imply."""
    gateways = [_gateway(name, table, config) for name, table in config.gateways.items()]
    for key, row in feature_tables().items():
        is_implied = row.implied_by and any(getattr(gateway.kind, row.implied_by) for gateway in gateways)
        if is_implied and key not in config.gateways:
            gateways.append(_gateway(key, {"class": row.plugin}, config))
    users: dict[type[object], tuple[HostService[object], str]] = {}
    for gateway in gateways:
        for service in gateway.kind.host_services(gateway.settings):
            shared, first = users.setdefault(service.kind, (service, gateway.name))
            if first != gateway.name and (service.name or service != shared):
                problem = f"only one gateway can have {service.name}, and gateways.{first} has them"
                if not service.name:
                    problem = f"it shares what runs with gateways.{first}: give both the same address"
                raise ConfigError(config.source, f"gateways.{gateway.name}", problem)
    return tuple(gateways)


def _gateway(name: str, table: Table, config: Config) -> PlannedComponent[Gateway]:
    key = "" if str(table.get("class")) in plugin_tables() else f"gateways.{name}"
    gateway = _component(Gateway, GATEWAYS, name, table, config, key)  # type: ignore[type-abstract]
    try:
        gateway.kind.check(gateway.settings)
    except UsageError as exc:
        raise ConfigError(config.source, f"gateways.{name}", str(exc)) from exc
    return gateway


def planned_app(
    name: str, table: Table, config: Config, given: type[App] | None = None, load_class: LoadPlugin = load_plugin
) -> PlannedComponent[App]:
    """Return the app *name* with the settings of its *table*, and the class *given*, or else loaded by *load_class*."""
    if given is not None and "class" in table:
        problem = f"the program gives the class {given.__name__} for this app; remove the key, or rename one of both"
        raise ConfigError(config.source, f"apps.{name}.class", problem)
    key = _key_of(name, table)
    if (array := _table_of(table)) and (check := feature_tables()[array].check):
        load(check)(name, table, config)
    if name in OWN_NODES or name in find_features().features:
        raise ConfigError(config.source, key, "is the name of one of homebot's own nodes; choose another name")
    scope_of(key, table, config.source)
    made = load_class if given is None else lambda *_: given
    return _component(App, APPS, name, without_act(table), config, key, made)  # type: ignore[type-abstract]


def _discovery(config: Config) -> DirectorySettings:
    settings = parse_settings(DirectorySettings, config.discovery, config.source, "discovery", config.folder)
    for name in settings.prefer:
        if name not in config.gateways:
            raise ConfigError(config.source, "discovery.prefer", no_such("gateway", name, config.gateways))
    return settings


def _control(config: Config) -> ControlSettings | None:
    if not config.control:
        return None
    settings = parse_settings(homebot.control.ControlSettings, config.control, config.source, "control", config.folder)
    if not settings.time_zone:
        settings = settings.model_copy(update={"time_zone": config.home.zone})
    if settings.presence_guard is not None and settings.presence_guard.doors:
        try:
            places = _places(config)
        except ConfigError:
            return settings  # reported separately
        _check_door_contacts(settings.presence_guard.doors, HousePlan(config.home.name, places.rooms), config.source)
    return settings


def _check_door_contacts(doors: Mapping[str, tuple[str, ...]], plan: HousePlan, source: str) -> None:
    """Check that each room is in *plan*, if that has rooms, and that each of its doors has a contact."""
    if not plan.rooms:
        return
    for name, contacts in doors.items():
        room = plan.room(name)
        if room is None:
            known = [room.name for room in plan.rooms]
            raise ConfigError(source, f"{_DOORS}.{name}", no_such("room", name, known))
        if len(contacts) < len(room.doors):
            joined = f"{len(room.doors)} doors (to {', '.join(room.doors)})"
            problem = f"{room.name} has {joined}, but only {len(contacts)} of them with a contact; each needs one"
            raise ConfigError(source, f"{_DOORS}.{name}", problem)


def _check_extra(source: str, key: str, *needed: str) -> None:
    try:
        check_extra(*needed)
    except UsageError as exc:
        raise ConfigError(source, key, str(exc)) from exc


def _interfaces(config: Config) -> Interfaces | None:
    if not config.ros:
        return None
    from homebot.messages.interfaces.settings import read_interfaces  # noqa: PLC0415 - only with the table

    return read_interfaces(config.ros, config.source, config.folder)


def _link(config: Config) -> RosSettings | None:
    if not config.ros:
        return None
    from homebot.messages.interfaces.settings import RosSettings  # noqa: PLC0415 - only with the table

    settings = parse_settings(RosSettings, config.ros, config.source, "ros", config.folder)
    if not settings.has_link:
        return None
    _check_extra(config.source, "ros", "the link to robots", "ros2", "zenoh", "xxhash")
    if len(settings.imports) > 1:
        from homebot.bridges.zenoh.rights import check_apart  # noqa: PLC0415 - only with several robots

        try:
            check_apart(settings)
        except UsageError as exc:
            raise ConfigError(config.source, "ros.import", str(exc)) from exc
    return settings


def _places(config: Config) -> Places:
    places = NO_PLACES
    if config.places:
        places = homebot.places.read_places(config.places, config.home.name, config.source, "configuration")
    return replace(places, groups=_groups(config)) if config.groups else places


def _groups(config: Config) -> Mapping[str, str]:
    if not config.groups:
        return {}
    from homebot.discovery.groups import read_groups  # noqa: PLC0415 - many homes have none

    return read_groups(config.groups, config.source)


def _features(config: Config) -> Mapping[str, Any]:
    return {key: _feature_table(key, config) for key in config.features}


def _feature_table(key: str, config: Config) -> Any:
    row = feature_tables().get(key)
    if row is None:
        left_out = "; ".join(f"{name}: {problem}" for name, problem in find_features().problems.items())
        raise ConfigError(config.source, key, f"is of no feature; left out are {left_out}")
    return load(row.reader)(config)


def _limits(config: Config) -> LimitsOfDevices | None:
    if not config.devices:
        return None
    from homebot.discovery.reading_limits import LimitSettings, LimitsOfDevices  # noqa: PLC0415 - only with a table

    read = partial(parse_settings, LimitSettings, source=config.source, folder=config.folder)
    return LimitsOfDevices({name: read(table, key=f"devices.{name}") for name, table in config.devices.items()})


def _robots(config: Config) -> Mapping[str, RobotSettings]:
    if not config.robots:
        return {}
    from homebot.robots.settings import read_robots  # noqa: PLC0415 - only with a table

    return read_robots(config.robots, config.source, config.folder)


def _notify(config: Config) -> NotifySettings | None:
    if config.notify is None:
        return None
    from homebot.apps.notifier import NotifySettings  # noqa: PLC0415 - only with the table

    settings = parse_settings(NotifySettings, config.notify, config.source, "notify", config.folder)
    if settings.address and settings.gateway not in config.gateways:
        problem = f"there is no gateway {settings.gateway!r} that could publish notifications"
        hint = did_you_mean(settings.gateway, config.gateways, "name one, or give urls of apprise")
        raise ConfigError(config.source, "notify.gateway", f"{problem}; {hint}")
    if settings.has_urls:
        _check_extra(config.source, "notify.urls", "[notify] with urls", "apprise", "apprise")
    return settings


_TABLES: Mapping[str, Callable[[Config], Any]] = {
    "discovery": _discovery,
    "control": _control,
    "door": read_rosbridge_settings,
    "interfaces": _interfaces,
    "places": _places,
    "limits": _limits,
    "robots": _robots,
    "link": _link,
    "notify": _notify,
    "features": _features,
}
"""The values of a plan that are each read from one table."""


def _component(
    base: type[ComponentT],
    group: str,
    name: str,
    table: Table,
    config: Config,
    key: str,
    load: LoadPlugin = load_plugin,
) -> PlannedComponent[ComponentT]:
    source = config.source
    wanted = table.get("class", name)
    if not isinstance(wanted, str):
        raise ConfigError(source, f"{key}.class", f"must be a text, module:Class or a plug-in's name, got {wanted!r}")
    try:
        kind = load(group, wanted)
    except PluginError as exc:
        raise ConfigError(source, f"{key}.class" if "class" in table else key, str(exc)) from exc
    # mistakes that would otherwise only show at the first start
    what = "an App" if base.__name__ == "App" else f"a {base.__name__}"
    if not issubclass(kind, base):
        raise ConfigError(source, f"{key}.class", f"{wanted} is not {what}; derive it from {base.__module__}")
    missing = sorted(getattr(kind, "__abstractmethods__", ()))
    if missing:
        raise ConfigError(source, f"{key}.class", f"{wanted} lacks {', '.join(f'{name}()' for name in missing)}")
    settings = getattr(kind, "Settings", None)
    if not isinstance(settings, type) or not issubclass(settings, BaseModel):
        raise ConfigError(source, f"{key}.class", f"{wanted}.Settings is not a pydantic model")
    return PlannedComponent(name, kind, parse_settings(kind.Settings, table, source, key, config.folder))
