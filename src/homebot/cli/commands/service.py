"""``homebot service``: ``list``, ``type``, ``call`` and ``install``."""

import argparse
import compileall
import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import homebot
from homebot.cli.arguments import DEFAULT_CONFIG, add_verb, add_verbs, seconds, set_command
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.graph_queries import Schema, add_list, entities, typedefs
from homebot.cli.remarks import print_error
from homebot.cli.yaml import message, to_yaml, type_or_message
from homebot.errors import PeerError, UsageError
from homebot.names import absolute_name
from homebot.support.names import did_you_mean
from homebot.support.printable import printable

_REQUEST, _RESPONSE = "/rosapi/service_request_details", "/rosapi/service_response_details"

_EXAMPLES = """\
  homebot service list -t
  homebot service call /rosapi/get_time
  homebot service install --user    run homebot when the computer starts
"""
_CALL_EXAMPLES = """\
  homebot service call /rosapi/get_time
  homebot service call /getIndexData '{service_type: lights}'
  homebot service call /rosapi/topic_type rosapi_msgs/srv/TopicType '{"topic": "/rosout"}'
"""

_INSTALL_EXAMPLES: Final = """\
  homebot service install --user          for you, with the homebot.toml of this folder
  sudo homebot service install --config /etc/homebot/homebot.toml
  homebot service install --user --print  show the unit without writing it
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
User=homebot
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


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    add_list(verbs, "service", "service")
    command = add_verb(verbs, "type", "print the type of a service")
    command.add_argument("service", metavar="SERVICE", help="name of the service")
    set_door_command(command, _type, "  homebot service type /rosapi/get_time\n")
    command = add_verb(verbs, "call", "call a service and print its response")
    command.add_argument("service", metavar="SERVICE", help="name of the service")
    command.add_argument(
        "type", metavar="TYPE", nargs="?", default="", type=type_or_message, help="expected type (default: any)"
    )
    command.add_argument(
        "request", metavar="REQUEST", nargs="?", default="{}", type=message, help="as JSON or as {field: value}"
    )
    command.add_argument("--timeout", metavar="S", type=seconds, default=5.0, help="seconds to wait (default: 5)")
    command.add_argument("--json", action="store_true", help="print the response as one line of JSON")
    set_door_command(command, _call, _CALL_EXAMPLES, acts=True)
    command = add_verb(verbs, "install", "install a systemd unit that runs homebot")
    set_command(command, _install, _INSTALL_EXAMPLES)
    command.add_argument("--user", action="store_true", help="a service of your user, not of the system")
    command.add_argument("--config", metavar="FILE", default=DEFAULT_CONFIG, help="the file (default: homebot.toml)")
    command.add_argument("--print", action="store_true", dest="only_print", help="print the unit without writing it")


def _call(door: DoorClient, options: argparse.Namespace) -> int:
    expected, request = options.type, options.request
    if isinstance(expected, dict):  # the type was omitted
        expected, request = "", expected
    ros_type = _type_of(door, options.service)
    if expected and "/" not in expected and not request:
        field = next(iter(typedefs(door, _REQUEST, ros_type)[0].fieldnames), "field")
        name, _, value = expected.rpartition("=")
        request = f"{{{name or field}: {value}}}"
        raise UsageError(f"{expected!r} was taken as a type; write the request as {request}")
    if expected and _without_kind(expected) != _without_kind(ros_type):
        raise PeerError(f"service {options.service} is a {ros_type}, not a {expected}")
    response = door.call(options.service, request, options.timeout)
    if options.json:
        print(json.dumps(response))
    else:
        print(to_yaml(Schema(typedefs(door, _RESPONSE, ros_type)).readable(response)), end="")
    return _exit_code(options.service, response, as_json=options.json)


def _type(door: DoorClient, options: argparse.Namespace) -> int:
    print(_type_of(door, options.service))
    return 0


def _type_of(door: DoorClient, service: str) -> str:
    known = {entity.name: entity.type for entity in entities(door, kind="service")}
    name = absolute_name(service)
    if name not in known:
        raise PeerError(f"there is no service {name}; {did_you_mean(name, known, '`homebot service list` lists all')}")
    return known[name]


def _without_kind(ros_type: str) -> str:
    package, _, name = ros_type.partition("/")
    return f"{package}/{name.rpartition('/')[2]}"


def _exit_code(service: str, response: Mapping[str, object], *, as_json: bool) -> int:
    """Print the failure that *response* reports, if any, in the fields of ROS services; return the exit code."""
    for name in ("success", "successful"):
        if response.get(name) is False:
            reason = next(
                (str(response[key]) for key in ("message", "reason") if response.get(key)), "it gave no reason"
            )
            print_error(f"{service} reported a failure: {printable(reason)}", as_json=as_json)
            return 1
    return 0


def unit_text(config: Path, *, is_user: bool) -> str:
    """Return the unit that runs homebot with the file *config*."""
    command = f"{_quote(sys.executable)} -m homebot run --config {_quote(str(config))}"
    paths = (config, Path(sys.executable))
    is_home = any(path.is_relative_to(folder) for path in paths for folder in ("/home", "/root"))
    more = "" if is_user else _SYSTEM.format(protect_home="read-only" if is_home else "yes")
    target = "default.target" if is_user else "multi-user.target"
    folder = str(config.parent).replace("%", "%%")
    return _UNIT.format(command=command, folder=folder, more=more, target=target)


def _install(options: argparse.Namespace) -> int:
    from homebot.cli.commands.config import plan_of  # noqa: PLC0415 - the other verbs need none of it

    config = Path(options.config).absolute()
    plan_of(config)  # checks it
    text = unit_text(config, is_user=options.user)
    if options.only_print:
        print(text, end="")
        return 0
    of_user = Path(os.environ.get("XDG_CONFIG_HOME") or Path.home() / ".config") / "systemd" / "user"
    file = (of_user if options.user else Path("/etc/systemd/system")) / "homebot.service"
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    except OSError as exc:
        hint = "" if options.user else "; use sudo, or --user"
        raise UsageError(f"{file} cannot be written: {exc.strerror}{hint}") from exc
    keep_compiled(Path(homebot.__file__).parent)
    systemctl = "systemctl --user" if options.user else "systemctl"
    print(f"wrote {file}; now:")
    if not options.user:
        print("  useradd --system homebot     if there is no such user yet")
    print(f"  {systemctl} daemon-reload\n  {systemctl} enable --now homebot")
    if options.user:
        print("  loginctl enable-linger       to keep it running while you are not logged in")
    return 0


def keep_compiled(package: Path) -> None:
    """Compile the modules of *package*, if its folder can be written: the service may write nothing beside its data."""
    compileall.compile_dir(package, quiet=2)


def _quote(path: str) -> str:
    escaped = path.replace("\\", "\\\\").replace('"', '\\"').replace("%", "%%").replace("$", "$$")
    return f'"{escaped}"'
