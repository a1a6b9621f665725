"""``homebot service install``: a systemd unit that runs homebot from the start of the computer."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import Final

from homebot.cli.arguments import DEFAULT_CONFIG, set_command
from homebot.errors import UsageError

__all__ = ["add_install_arguments", "unit_text"]

_EXAMPLES: Final = """\
  homebot service install --user          for you, with the homebot.toml of this folder
  sudo homebot service install --config /etc/homebot/homebot.toml
  homebot service install --user --print  show the unit, and write nothing
"""

_UNIT: Final = """\
[Unit]
Description=homebot, the home runtime for robots
Documentation=https://www.freedesktop.org/software/systemd/man/systemd.service.html
Wants=network-online.target
After=network-online.target

[Service]
Type=notify
ExecStart={command}
ExecReload=kill -HUP $MAINPID
WorkingDirectory={folder}
Restart=on-failure
RestartSec=5
RestartPreventExitStatus=2
TimeoutStartSec=120
TimeoutStopSec=15
WatchdogSec=30
UMask=0077
NoNewPrivileges=yes
LockPersonality=yes
RestrictRealtime=yes
RestrictSUIDSGID=yes
RestrictNamespaces=yes
SystemCallArchitectures=native
SystemCallFilter=@system-service
RestrictAddressFamilies=AF_UNIX AF_INET AF_INET6 AF_NETLINK AF_BLUETOOTH
{more}
[Install]
WantedBy={target}
"""

_SYSTEM: Final = """\
DynamicUser=yes
StateDirectory=homebot
Environment=HOMEBOT_DATA=%S/homebot
EnvironmentFile=-/etc/homebot/environment
SupplementaryGroups=dialout
CapabilityBoundingSet=
ProtectSystem=strict
ProtectHome={protect_home}
PrivateTmp=yes
ProtectKernelTunables=yes
ProtectKernelModules=yes
ProtectKernelLogs=yes
ProtectControlGroups=yes
ProtectClock=yes
ProtectHostname=yes
ProtectProc=invisible
DevicePolicy=closed
DeviceAllow=char-ttyUSB rw
DeviceAllow=char-ttyACM rw
"""


def add_install_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot service install``."""
    set_command(parser, _install, _EXAMPLES)
    parser.add_argument("--user", action="store_true", help="a service of yours, not of the computer")
    parser.add_argument("--config", metavar="FILE", default=DEFAULT_CONFIG, help="the file (default: homebot.toml)")
    parser.add_argument("--print", action="store_true", dest="only_print", help="print the unit, and write nothing")


def unit_text(config: Path, *, is_user: bool) -> str:
    """Return the unit that runs homebot with the file *config*."""
    command = f"{_quoted(sys.executable)} -m homebot run --config {_quoted(str(config))}"
    paths = (config, Path(sys.executable))
    is_home = any(path.is_relative_to(folder) for path in paths for folder in ("/home", "/root"))
    more = "" if is_user else _SYSTEM.format(protect_home="read-only" if is_home else "yes")
    target = "default.target" if is_user else "multi-user.target"
    folder = str(config.parent).replace("%", "%%")
    return _UNIT.format(command=command, folder=folder, more=more, target=target)


def _install(options: argparse.Namespace) -> int:
    """Check the configuration, and write the unit."""
    from homebot.cli.commands.config import plan_of  # noqa: PLC0415 - the other verbs need none of it

    config = Path(options.config).absolute()
    plan_of(config)  # checks it
    text = unit_text(config, is_user=options.user)
    if options.only_print:
        print(text, end="")
        return 0
    file = _folder(is_user=options.user) / "homebot.service"
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    except OSError as exc:
        hint = "" if options.user else "; use sudo, or --user"
        raise UsageError(f"{file} cannot be written: {exc.strerror}{hint}") from exc
    systemctl = "systemctl --user" if options.user else "systemctl"
    print(f"wrote {file}; now:\n  {systemctl} daemon-reload\n  {systemctl} enable --now homebot")
    if options.user:
        print("  loginctl enable-linger       so that it runs while you are not logged in")
    return 0


def _folder(*, is_user: bool) -> Path:
    if not is_user:
        return Path("/etc/systemd/system")
    return Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config") / "systemd" / "user"


def _quoted(path: str) -> str:
    """Return *path* as a word of ``ExecStart``."""
    escaped = path.replace("\\", "\\\\").replace('"', '\\"').replace("%", "%%").replace("$", "$$")
    return f'"{escaped}"'
