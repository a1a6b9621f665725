"""``homebot run``: one homebot until Ctrl-C, SIGTERM or the end of its time."""

from __future__ import annotations

import argparse
import asyncio
import atexit
import gc
import os
import sys
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Iterator, Mapping
from contextlib import AsyncExitStack, ExitStack, asynccontextmanager, contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias, cast

import anyio

from homebot.cli.arguments import (
    DEFAULT_CONFIG,
    ServerHost,
    add_log_format,
    add_time_limit,
    server_address,
    server_of_environment,
    set_command,
)
from homebot.cli.main import gc_paused
from homebot.cli.serve import on_an_event_loop, serve
from homebot.config import WITH_COMMAND_LINE, Config, load_config, load_tables, parse_config
from homebot.errors import ConfigError, UsageError
from homebot.feature import RunOption, all_features, load
from homebot.log import LogFormat, configure_logging
from homebot.plugins import add_app, app_of, check_extra, is_file, name_in_file
from homebot.support.output import queued_output
from homebot.support.owner_token import OWNER_FILE
from homebot.support.production_loop import ProductionLoop

if TYPE_CHECKING:
    from contextlib import AbstractAsyncContextManager

    from homebot.feature_context import RunObserver
    from homebot.house import World
    from homebot.runtime import Runtime

_View: TypeAlias = "Callable[[Runtime], AbstractAsyncContextManager[None]]"
"""Enters a runtime, perhaps with a live view."""

_AGAIN: Final = -1
_WRONG_CONFIGURATION = 2
"""Exit code of a service with a wrong configuration: restarting it does not help."""

COMMAND_LINE = "command line"
THESIS_ROOT = "home425"
THESIS, FAMILY, OFFICE = "thesis", "family", "office"
"""The names of the built-in simulated houses."""

_HOUSES: Final = Path(__file__).parents[2] / "house"
APPS_OF_THE_SIMULATED_HOUSE = ("light_service",)
"""The apps of a simulated house. In a real house no app runs by default: the light service turns off every lamp."""

ROBOT_OF_THE_SIMULATED_HOUSE = "robot"

_TOKEN = "HOMEBOT_DOOR_TOKEN"  # noqa: S105 - the name of a variable

_EXAMPLES = """\
  homebot run                                     embedded broker, a simulated family's house, live in the terminal
  homebot run --plain                             the same, with the log instead of the live view
  homebot run --for 15                            the same, for 15 seconds
  homebot run --house thesis                      a small house of two lamps, in real time, with the light service
  homebot run --house villa.toml                  a house that you describe, with the light service
  homebot run --mqtt mqtt://192.168.1.10 --root home425      your own broker, observing only
  homebot run --mqtt mqtt://192.168.1.10 --root home425 --act --app light_service    sending commands, with an app
  homebot run --house family --mqtt mqtt://127.0.0.1 --act   a simulated house on your own broker, without its apps
  homebot run --app my_app.py                     an app of your own in the small house
  homebot run --app my_app.py --reload            the same, reloaded whenever you save it
  homebot run --config homebot.toml --dry-run     show commands of apps without sending any
  homebot run --config homebot.toml               all settings in a file
  homebot run --new                               a home of your own, whose page asks for all settings

Without --config, homebot.toml in the working directory is used if it exists. Ctrl-C shuts down cleanly.
A service (NOTIFY_SOCKET or HOMEBOT_SERVICE is set) needs a configuration; it exits with 2 if that is wrong, and with 1
if no gateway was connected within five minutes. With --for, 1 also means that a gateway was never connected.
Devices are remembered in HOMEBOT_DATA (default: the user's data directory), except those of a simulated house.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_command(parser, run, _EXAMPLES, ("door",))
    _add_sources(parser)
    parser.add_argument(
        "--door",
        metavar="HOST:PORT",
        type=server_address,
        default=argparse.SUPPRESS,  # the option may also come before the command
        help="address to listen on for rosbridge clients (default: [door], else HOMEBOT_DOOR, else 127.0.0.1:9090)",
    )
    parser.add_argument(
        "--plain", action="store_true", help="print the log instead of a live view, as without a terminal"
    )
    add_log_format(parser)
    parser.add_argument(
        "--dry-run",
        action="store_true",
        help="send nothing to any device: only log and journal the commands of apps",
    )
    parser.add_argument("--reload", action="store_true", help="reload an app when its file changes")
    for name, option in _run_options().items():
        parser.add_argument(f"--{name}", metavar=option.metavar, help=option.purpose)
    parser.add_argument("--ephemeral", action="store_true", help="do not remember devices across restarts")
    add_time_limit(parser)


def _add_sources(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--config", metavar="FILE", help="configuration file in TOML (default: homebot.toml, if it exists)"
    )
    parser.add_argument(
        "--new", action="store_true", help="begin a home of your own: write the file if there is none, and use its page"
    )
    parser.add_argument(
        "--house",
        metavar="NAME|FILE",
        help="simulated house: family, office, thesis, or a file in TOML (default, if neither --config nor --mqtt is "
        "given: family; with --app or --root thesis), on the embedded broker, or on that of --mqtt",
    )
    parser.add_argument(
        "--mqtt",
        metavar="URL",
        help="broker of the gateway `mqtt`, as mqtt://[user@]host[:port], and of the devices of --house",
    )
    parser.add_argument(
        "--root",
        metavar="NAME",
        help="first MQTT topic level of devices without announcements, such as home425 (default: the name of the home)",
    )
    parser.add_argument(
        "--app",
        metavar="NAME",
        type=_app,
        action="append",
        default=[],
        help="app to run: a plug-in's name, module:Class or a Python file; may be given more than once (default: "
        "those of the simulated house, none with your own broker)",
    )
    parser.add_argument(
        "--act", action="store_true", help="allow the gateway `mqtt` to send commands to an external broker"
    )


def is_service() -> bool:
    """Return whether a service manager or a container started the process."""
    return not os.environ.keys().isdisjoint({"NOTIFY_SOCKET", "HOMEBOT_SERVICE"})


def _app(text: str) -> str:
    module, colon, kind = text.partition(":")
    names = (*module.split("."), kind) if colon else (text,)
    if all(name.isidentifier() for name in names):
        return text
    if not is_file(text):
        raise argparse.ArgumentTypeError(
            f"an app is a plug-in's name, module:Class, FILE.py or FILE.py:Class, got {text!r}"
        )
    return text


def run(options: argparse.Namespace) -> int:
    """Run until told to stop; return 0, or 1 if a component was given up, or what was to connect never did."""
    try:
        return run_configured(options)
    except UsageError as exc:
        for problem in _problems(exc, options.config):
            print(f"homebot: {problem}", file=sys.stderr)
        return _WRONG_CONFIGURATION if is_service() else 1


def _problems(first: UsageError, path: str | None) -> Iterable[UsageError]:
    """Return *first* and all other mistakes in the configuration, as in ``homebot config check``."""
    if not isinstance(first, ConfigError):
        return (first,)
    errors = _locate((first, *first.others))
    with suppress(ConfigError):
        errors += config_errors(load_tables(Path(path)), Path(path)) if path else ()
    return [*{(error.key, error.reason): error for error in reversed(errors)}.values()][::-1]


def config_errors(tables: Mapping[str, object], path: Path) -> tuple[ConfigError, ...]:
    """Return all mistakes in *tables*; the content of a malformed table is not checked."""
    from homebot.runtime.plan import plan_errors  # noqa: PLC0415 - after a mistake alone

    try:
        return _locate(plan_errors(with_environment(parse_config(tables, str(path), path.parent))))
    except ConfigError as exc:
        errors = _locate((exc, *exc.others))
        wrong = {error.key.partition(".")[0] for error in errors}
    rest = {name: table for name, table in tables.items() if name not in wrong}
    return (*errors, *config_errors(rest, path)) if len(rest) < len(tables) else errors


def _locate(errors: Iterable[ConfigError]) -> tuple[ConfigError, ...]:
    from homebot.config_lines import located  # noqa: PLC0415 - after a mistake alone

    return tuple(map(located, errors))


def _complete(options: argparse.Namespace) -> None:
    """Add the file of the configuration, and check the installed packages."""
    if options.new:
        if options.house or options.mqtt:
            raise UsageError("--new begins a home of real devices; leave --house and --mqtt out")
        from homebot.cli.new_home import begin_home  # noqa: PLC0415 - once in the life of a home
        from homebot.support.data_folder import data_directory  # noqa: PLC0415 - as above

        begin_home(Path(options.config or DEFAULT_CONFIG), options.door, data_directory() / OWNER_FILE)
    if not options.config and DEFAULT_CONFIG.exists():
        options.config = str(DEFAULT_CONFIG)  # if it is missing at a reload, that is a mistake, not a simulated house
    if options.reload:
        check_extra("--reload", "watchfiles", "watchfiles")


def _print_slow_start(options: argparse.Namespace) -> None:
    if _is_simulated(options) and house_name(options) != THESIS:
        print("homebot · a simulated house is starting …", flush=True)


def run_configured(options: argparse.Namespace) -> int:
    """Run with *options*, and raise the first UsageError; return the same as :func:`run`."""
    _complete(options)
    is_watched = _is_watched(options)
    if is_watched:
        _print_slow_start(options)
    with gc_paused():
        config, house = configuration(options)
    view = partial(_watch, house) if is_watched and house is not None and not house.time.is_real else None
    with (
        queued_output() as lost_lines,
        _observers(options) as observers,
        _log(options.log_format, is_quiet=view is not None),
    ):
        atexit.register(gc.freeze)  # else the final garbage collection takes seconds
        with gc_paused():
            from homebot.runtime import Runtime  # noqa: PLC0415 - most of the start, after the first line
        _check_named_apps(options, config)
        index_file, owner_file = None, None
        if house is None or options.config or options.mqtt:
            from homebot.runtime.home_folder import settle_home  # noqa: PLC0415 - a simulated house keeps nothing
            from homebot.support.data_folder import data_directory  # noqa: PLC0415 - as above

            owner_file = data_directory() / OWNER_FILE
            if house is None and not options.ephemeral:
                index_file = settle_home(config, Path(options.config) if options.config else None)
        read = partial(_config, options)
        make_runtime = partial(
            Runtime,
            config,
            house=house,
            robot=ROBOT_OF_THE_SIMULATED_HOUSE,
            house_broker=options.mqtt or "",
            index_file=index_file,
            owner_file=owner_file,
            lost_lines=lost_lines,
            observers=observers,
            is_dry_run=options.dry_run,
            read_config=read,
            watches_apps=options.reload,
            show_code=_show_code(options, config),
        )
        result = on_an_event_loop(_run(make_runtime, options.seconds, read, view))
    if result == _AGAIN:
        os.execv(sys.executable, [sys.executable, *sys.orig_argv[1:]])  # noqa: S606 - the same program, and no shell
    return result


def _show_code(options: argparse.Namespace, config: Config) -> Callable[[str, str], None] | None:
    """Return the function that prints the code of a new home, or of any to a person at the terminal; None for none."""
    if not options.config or is_service() or not (options.new or not config.gateways or sys.stdout.isatty()):
        return None
    from homebot.cli.new_home import print_way_in  # noqa: PLC0415 - for a terminal alone

    return print_way_in


def _check_named_apps(options: argparse.Namespace, config: Config) -> None:
    """Raise the mistake of an app that the command line names; a wrong one of the file is left out."""
    from homebot.runtime.plan import planned_app  # noqa: PLC0415 - as above

    for wanted in options.app:
        name = app_of(config.apps, _with_its_class(wanted) if is_file(wanted) else wanted)
        planned_app(name, config.apps[name], config)


def _config(options: argparse.Namespace) -> Config:
    return configuration(options, may_be_cut=True)[0]


@contextmanager
def _log(log_format: LogFormat | None, *, is_quiet: bool) -> Iterator[None]:
    """Configure the log; if quiet, its lines are shown after the live view is closed."""
    if is_quiet:
        from homebot.cli.live_house import quiet_log  # noqa: PLC0415 - for a terminal alone

        with quiet_log():
            yield
        return
    if log_format is not None:
        configure_logging(log_format)
    yield


@contextmanager
def _observers(options: argparse.Namespace) -> Iterator[Mapping[str, RunObserver]]:
    with ExitStack() as stack:
        given = {name: value for name in _run_options() if (value := getattr(options, name)) is not None}
        yield {name: stack.enter_context(load(_run_options()[name].opens)(value)) for name, value in given.items()}


def _run_options() -> Mapping[str, RunOption]:
    return {name: option for feature in all_features() for name, option in feature.run_options.items()}


def configuration(options: argparse.Namespace, *, may_be_cut: bool = False) -> tuple[Config, World | None]:
    """Return the configuration for *options*, whose file may be half saved, and its simulated house, if any.

    Raises:
        ConfigError: The file cannot be used, or a value is wrong.
    """
    base, house = _base(options, may_be_cut=may_be_cut)
    if options.house:
        house = _house(options.house)
    tables = base.model_dump()
    stated = {"url": options.mqtt, "root": options.root, "act": options.act}
    stated = {key: value for key, value in stated.items() if value}
    if stated:
        tables["gateways"].setdefault("mqtt", {}).update(stated)
    for name in options.app:
        add_app(tables["apps"], _with_its_class(name) if is_file(name) else name)
    if options.door:
        tables["door"].update(_listens(options.door))
    is_changed = bool(stated or options.app)
    source = f"{base.source}{WITH_COMMAND_LINE}" if is_changed and base.source != COMMAND_LINE else base.source
    return with_environment(parse_config(tables, source, base.folder)), house


def _listens(address: ServerHost) -> dict[str, object]:
    return {"host": address.host, "port": address.port, **({"tls": True} if address.has_tls else {})}


def with_environment(config: Config) -> Config:
    """Return *config*, with the door's address and token from the environment if it has none."""
    door = config.door
    if not door.keys() & {"host", "port"} and (address := server_of_environment()):
        door = {**door, **_listens(address)}
    if (token := os.environ.get(_TOKEN)) and not door.keys() & {"token", "token_file", "tokens"}:
        door = {**door, "token": token}
    return config.model_copy(update={"door": door})


def _base(options: argparse.Namespace, *, may_be_cut: bool) -> tuple[Config, World | None]:
    if options.config or DEFAULT_CONFIG.exists():
        return load_config(Path(options.config or DEFAULT_CONFIG), may_be_cut=may_be_cut), None
    if options.mqtt and not options.house:
        home = {"name": options.root} if options.root else {}
        return parse_config({"home": home, "gateways": {"mqtt": {}}}, COMMAND_LINE), None
    if is_service() and not options.house:
        raise UsageError(f"{DEFAULT_CONFIG} does not exist, and a service runs no simulated house; give --config FILE")
    name = house_name(options)
    config = load_config(_HOUSES / name / "home.toml") if name in {FAMILY, OFFICE} else _thesis_config(options)
    if options.mqtt:  # real devices may be there, which only apps that are named may command
        config = config.model_copy(
            update={"apps": {name: config.apps[name] for name in options.app if name in config.apps}}
        )
    return config, None if options.house else _house(name)


def _thesis_config(options: argparse.Namespace) -> Config:
    root = options.root or THESIS_ROOT
    apps: dict[str, object] = {} if options.app else {name: {} for name in APPS_OF_THE_SIMULATED_HOUSE}
    tables = {"home": {"name": root}, "gateways": {"mqtt": {"root": root}}, "apps": apps}
    return parse_config(tables, COMMAND_LINE)


def _is_watched(options: argparse.Namespace) -> bool:
    has_screen = sys.stdout.isatty() and os.environ.get("TERM", "dumb") not in {"", "dumb", "unknown"}
    return has_screen and not options.plain and options.log_format == "console"


def _is_simulated(options: argparse.Namespace) -> bool:
    return bool(options.house) or not (options.config or options.mqtt or DEFAULT_CONFIG.exists() or is_service())


def house_name(options: argparse.Namespace) -> str:
    """Return the name or file of the house that runs without a configuration; a custom app gets the small house."""
    return cast("str", options.house) or (THESIS if options.app or options.root else FAMILY)


def _house(name: str) -> World:
    import homebot.house  # noqa: PLC0415 - a real house needs no simulated one

    if name == THESIS:
        return homebot.house.thesis_world()
    built_in = {FAMILY: homebot.house.family_world, OFFICE: homebot.house.office_world}
    return built_in[name]() if name in built_in else homebot.house.load_world(Path(name))


def _with_its_class(file: str) -> str:
    from homebot.apps import App  # noqa: PLC0415 - few runs name a file

    return name_in_file(file, App)


async def _run(
    make_runtime: Callable[..., Runtime], seconds: float | None, read: Callable[[], Config], view: _View | None = None
) -> int:
    """Return the exit code, or that homebot is to begin again."""
    loop = asyncio.get_running_loop()
    watch = loop.watch if isinstance(loop, ProductionLoop) else None
    with gc_paused():  # loads the plug-ins of the plan
        again = anyio.Event()
        runtime = make_runtime(loop_watch=watch, restart=again.set)
    service, reload = (view or _settle)(runtime), partial(runtime.reload, read)
    if seconds is None and not is_service():
        await serve(service, None, runtime.cut_start_short, reload, again.wait)
        return _AGAIN if again.is_set() else 1 if runtime.supervisor.given_up else 0
    from homebot.cli.service_manager import FirstConnection  # noqa: PLC0415 - others need none

    first = FirstConnection(runtime.graph, runtime.config.gateways, is_service=is_service())
    watched = first.watched(service)
    if await serve(
        watched, seconds, runtime.cut_start_short, reload, partial(_first_of, first.wait_in_vain, again.wait)
    ):
        first.log_missing(seconds)
    return _AGAIN if again.is_set() else 1 if runtime.supervisor.given_up or first.is_missing else 0


async def _first_of(*waits: Callable[[], Awaitable[None]]) -> None:
    """Wait until one of them is over."""
    async with anyio.create_task_group() as tasks:

        async def run(wait: Callable[[], Awaitable[None]]) -> None:
            await wait()
            tasks.cancel_scope.cancel()

        for wait in waits:
            tasks.start_soon(run, wait)


@asynccontextmanager
async def _watch(world: World, runtime: Runtime) -> AsyncIterator[None]:
    async with _settle(runtime):
        from homebot.cli.live_house import shown  # noqa: PLC0415 - for a terminal alone

        async with shown(runtime.graph, world, "" if runtime.rosbridge is None else runtime.rosbridge.page):
            yield


@asynccontextmanager
async def _settle(runtime: Runtime) -> AsyncIterator[None]:
    """Enter *runtime*; objects that exist then, mostly modules and classes, are exempt from garbage collection."""
    async with AsyncExitStack() as stack:
        with gc_paused():
            await stack.enter_async_context(runtime)
        yield
