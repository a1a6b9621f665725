"""``homebot run``: one homebot until Ctrl-C, SIGTERM or the end of its time."""

from __future__ import annotations

import argparse
import asyncio
import os
import re
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import anyio

from homebot.cli.watchdog import Watchdog
from homebot.config import Config, load_config, parse_config
from homebot.log import configure_logging
from homebot.runtime import Runtime

__all__ = ["configuration", "run", "with_door_token"]

COMMAND_LINE = "command line"
DEFAULT_CONFIG = Path("homebot.toml")
THESIS_ROOT = "home425"
DEFAULT_APPS = ("light_service",)


def run(options: argparse.Namespace) -> int:
    """Run until told to stop; return 0, or 1 when a part was given up on the way."""
    config, with_house = configuration(options)
    configure_logging(options.log_format)
    # A selector loop on every platform: the MQTT client needs its add_reader.
    with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:
        return runner.run(_run(config, with_house=with_house, seconds=options.seconds))


def configuration(options: argparse.Namespace) -> tuple[Config, bool]:
    """Return what *options* ask for, and whether the simulated house belongs to it.

    Raises:
        ConfigError: The file cannot be used, or a value is wrong.
    """
    base, with_house = _base(options)
    tables = base.model_dump()
    is_changed = bool(options.mqtt or options.root or options.act or options.app)
    mqtt = tables["gateways"].setdefault("mqtt", {}) if options.mqtt or options.root or options.act else {}
    if options.mqtt:
        mqtt["url"] = options.mqtt
    if options.root:
        mqtt["root"] = options.root
    if options.act:
        mqtt["act"] = True
    for name in options.app:
        _add_app(tables["apps"], name)
    if options.door:
        tables["door"].update(host=options.door[0], port=options.door[1])
    source = f"{base.source} and command line" if is_changed and base.source != COMMAND_LINE else base.source
    return with_door_token(parse_config(tables, source)), with_house


def with_door_token(config: Config) -> Config:
    """Return *config* with the door's token from the environment, where the file has none."""
    token = os.environ.get("HOMEBOT_DOOR_TOKEN")
    if not token or config.door.keys() & {"token", "token_file"}:
        return config
    return config.model_copy(update={"door": {**config.door, "token": token}})


def _base(options: argparse.Namespace) -> tuple[Config, bool]:
    path = Path(options.config) if options.config else DEFAULT_CONFIG
    if options.config or path.exists():
        return load_config(path), False
    apps: dict[str, object] = {} if options.app else {name: {} for name in DEFAULT_APPS}
    if options.mqtt:
        home = {"name": options.root} if options.root else {}
        return parse_config({"home": home, "gateways": {"mqtt": {}}, "apps": apps}, COMMAND_LINE), False
    root = options.root or THESIS_ROOT
    tables = {"home": {"name": root}, "gateways": {"mqtt": {"root": root}}, "apps": apps}
    return parse_config(tables, COMMAND_LINE), True


def _add_app(apps: dict[str, dict[str, object]], wanted: str) -> None:
    """Add a table for the app *wanted* unless there is one; a class MyApp runs as my_app."""
    if any(table.get("class", name) == wanted for name, table in apps.items()):
        return
    if ":" not in wanted:
        apps[wanted] = {}
        return
    class_name = wanted.rpartition(":")[2]
    first = name = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", class_name).lower()
    number = 1
    while name in apps:
        number += 1
        name = f"{first}_{number}"
    apps[name] = {"class": wanted}


async def _run(config: Config, *, with_house: bool, seconds: float | None) -> int:
    runtime = Runtime(config, with_house=with_house)
    told_to_stop = anyio.Event()

    def stop() -> None:
        told_to_stop.set()
        runtime.cut_start_short()

    with Watchdog() as watchdog, _at_signals(watchdog.start, stop):
        async with runtime:
            with anyio.move_on_after(seconds):
                await told_to_stop.wait()
            watchdog.start()
    return 1 if runtime.supervisor.given_up else 0


@contextmanager
def _at_signals(at_once: Callable[[], None], in_the_loop: Callable[[], None]) -> Iterator[None]:
    """Call both at SIGINT and SIGTERM, *at_once* also while the event loop is blocked."""
    loop = asyncio.get_running_loop()

    def handle(_number: int, _frame: FrameType | None) -> None:
        at_once()
        loop.call_soon_threadsafe(in_the_loop)

    before = {number: signal.signal(number, handle) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
