"""``homebot run``: one homebot until Ctrl-C, SIGTERM or the end of its time."""

from __future__ import annotations

import argparse
import asyncio
import os
import re
import signal
import sys
import threading
from pathlib import Path

import anyio

from homebot.config import Config, load_config, parse_config
from homebot.log import configure_logging
from homebot.runtime import Runtime

__all__ = ["configuration", "run"]

STOP_WITHIN = 5.0
"""Seconds for a clean stop; whatever still hangs then is left behind."""

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
    base, source, with_house = _base(options)
    tables = base.model_dump()
    mqtt = tables["gateways"].setdefault("mqtt", {}) if options.mqtt or options.root or options.act else {}
    if options.mqtt:
        mqtt["url"] = options.mqtt
    if options.root:
        mqtt["root"] = options.root
    if options.act:
        mqtt["act"] = True
    for name in options.app:
        tables["apps"].update([_app(name)])
    if options.door:
        tables["door"].update(host=options.door[0], port=options.door[1])
    if "HOMEBOT_DOOR_TOKEN" in os.environ:
        tables["door"].setdefault("token", os.environ["HOMEBOT_DOOR_TOKEN"])
    return parse_config(tables, source), with_house


def _base(options: argparse.Namespace) -> tuple[Config, str, bool]:
    path = Path(options.config) if options.config else DEFAULT_CONFIG
    if options.config or path.exists():
        return load_config(path), str(path), False
    apps: dict[str, object] = {} if options.app else {name: {} for name in DEFAULT_APPS}
    source = "command line"
    if options.mqtt:
        return parse_config({"gateways": {"mqtt": {}}, "apps": apps}, source), source, False
    tables = {"home": {"name": THESIS_ROOT}, "gateways": {"mqtt": {"root": THESIS_ROOT}}, "apps": apps}
    return parse_config(tables, source), source, True


def _app(name: str) -> tuple[str, dict[str, object]]:
    """The app's table by the name of its node: a class MyApp runs as my_app."""
    if ":" not in name:
        return name, {}
    class_name = name.rpartition(":")[2]
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", class_name).lower(), {"class": name}


async def _run(config: Config, *, with_house: bool, seconds: float | None) -> int:
    runtime = Runtime(config, with_house=with_house)
    with anyio.open_signal_receiver(signal.SIGINT, signal.SIGTERM) as signals:
        async with runtime:
            with anyio.move_on_after(seconds):
                await anext(aiter(signals))
            watchdog = threading.Timer(STOP_WITHIN, _leave_behind)
            watchdog.daemon = True
            watchdog.start()
        watchdog.cancel()
    return 1 if runtime.supervisor.given_up else 0


def _leave_behind() -> None:
    print(f"homebot: not everything stopped within {STOP_WITHIN:g} s; leaving it behind", file=sys.stderr, flush=True)
    os._exit(1)
