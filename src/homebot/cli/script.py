"""Start of a homebot from a Python script, in the same way as ``homebot run``."""

from __future__ import annotations

import asyncio
import sys
import threading
from os import PathLike
from typing import TYPE_CHECKING

import structlog

from homebot.cli.commands.run import run_configured
from homebot.cli.main import make_parser
from homebot.errors import UsageError

if TYPE_CHECKING:
    from types import FrameType

    from homebot.apps import App


def run(
    *apps: type[App] | str,
    config: str | PathLike[str] | None = None,
    house: str | PathLike[str] | None = None,
    mqtt: str | None = None,
    root: str | None = None,
    act: bool = False,
    ephemeral: bool = False,
    seconds: float | None = None,
) -> int:
    """Run a homebot with *apps* until Ctrl-C or SIGTERM, like ``homebot run`` with the options of these names.

    Without *config*, a ``homebot.toml`` in the working directory is used; without that and *mqtt*, a simulated house.
    The log goes to standard error, unless structlog is already configured. At the end everything is stopped in order,
    within 4.8 s; then the process exits even if something hangs.

    Args:
        apps: Classes, or names of installed apps such as ``"light_service"``; without any, those of the configuration.
        config: Configuration in TOML.
        house: Simulated house in TOML, on the embedded broker, or that of *mqtt*.
        mqtt: URL of a broker, as ``mqtt://[user@]host[:port]``.
        root: First level of the topics of devices that do not announce themselves.
        act: Send commands to devices on a broker other than the embedded one.
        ephemeral: Do not keep devices across restarts.

    Returns:
        0, or 1 if an app or another component was given up.

    Raises:
        UsageError: Something cannot be run as configured; a class is not at the top level of its module; this is not
            the main thread, or an event loop is running in it.
    """
    _check_caller()
    options = make_parser(["run"]).parse_args(["run"])
    options.app = [app if isinstance(app, str) else _plugin_name(app) for app in apps]
    vars(options).update(config=config, house=house, mqtt=mqtt, root=root, act=act, ephemeral=ephemeral)
    options.seconds, options.plain = seconds, True
    if structlog.is_configured():
        options.log_format = None
    return run_configured(options)


def _check_caller() -> None:
    frame: FrameType | None = sys._getframe()  # noqa: SLF001 - the one way to see by which code a file is loaded
    while frame is not None:
        if frame.f_globals.get("__name__") == "homebot.plugins":
            raise UsageError('homebot loads this file itself; put run() below `if __name__ == "__main__":`')
        frame = frame.f_back
    if threading.current_thread() is not threading.main_thread():
        raise UsageError("run() only works in the main thread, where Ctrl-C arrives; elsewhere use Runtime")
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return
    raise UsageError("run() starts its own event loop; inside a running one use `async with Runtime(config)`")


def _plugin_name(app: type[App]) -> str:
    if getattr(sys.modules.get(app.__module__), app.__name__, None) is not app:
        raise UsageError(f"{app.__qualname__} is not found in {app.__module__}; define it at the top level there")
    return f"{app.__module__}:{app.__name__}"
