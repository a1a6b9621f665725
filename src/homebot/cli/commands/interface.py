"""``homebot interface list``, ``show`` and ``import``."""

import argparse
from collections.abc import Callable
from pathlib import Path

from homebot.bridges.rosbridge.types import own_modules
from homebot.cli.arguments import DEFAULT_CONFIG, add_verb, add_verbs, set_command
from homebot.config import load_config
from homebot.errors import UnknownTypeError, UsageError
from homebot.messages.interfaces import Interfaces
from homebot.messages.interfaces.interface_text import Interface
from homebot.messages.interfaces.settings import read_interfaces
from homebot.messages.type_hash import type_hash

_EXAMPLES = """\
  homebot interface list nav2_msgs
  homebot interface show nav2_msgs/action/NavigateToPose
  homebot interface import ~/ros2_ws/src
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    listed = add_verb(verbs, "list", "list messages, services and actions")
    listed.add_argument("package", metavar="PACKAGE", nargs="?", default="", help="only those of this package")
    show = add_verb(verbs, "show", "print the definition of a type, and its hash in ROS 2")
    show.add_argument("type", metavar="TYPE", help="PACKAGE/msg/NAME, or with srv or action instead of msg")
    imported = add_verb(verbs, "import", "check and copy the definitions of a workspace, for the table [ros]")
    imported.add_argument("folder", metavar="DIR", type=Path, help="folder with packages in it, at any depth")
    imported.add_argument(
        "--into", metavar="DIR", type=Path, default=Path("interfaces"), help="target folder (default: interfaces)"
    )
    for verb, command in ((listed, _list), (show, _show), (imported, _import)):
        set_command(verb, command, _EXAMPLES)
        verb.add_argument("--config", metavar="FILE", type=Path, help="the file with [ros] (default: homebot.toml)")


def _interfaces(options: argparse.Namespace) -> Interfaces:
    path = options.config or (DEFAULT_CONFIG if DEFAULT_CONFIG.exists() else None)
    known = read_interfaces(load_config(path).ros if path else {}, str(path), path.parent if path else Path())
    known.add_modules("homebot", own_modules())
    return known


def _list(options: argparse.Namespace) -> int:
    names = _interfaces(options).names(options.package)
    if not names:
        raise UsageError(f"there is no package {options.package!r}; homebot interface list shows all")
    print("\n".join(names))
    return 0


def _show(options: argparse.Namespace) -> int:
    known = _interfaces(options)
    found = _resolve(known, options.type)
    text = known.text(found.ros_type, found.ros_type.split("/")[1])
    print(f"# {found.ros_type}\n# {type_hash(found)}\n{text}", end="")
    return 0


def _resolve(known: Interfaces, ros_type: str) -> Interface:
    """Return the interface called *ros_type*, of the first kind with such a name.

    Raises:
        UnknownTypeError: No kind has it; the error is that of a kind with similar names, if there is one.
    """
    unknown: list[UnknownTypeError] = []
    finders: tuple[Callable[[str], Interface], ...] = (known.find_message, known.find_service, known.find_action)
    for find in finders:
        try:
            return find(ros_type)
        except UnknownTypeError as exc:
            unknown.append(exc)
    raise max(unknown, key=lambda error: len(str(error)))


def _import(options: argparse.Namespace) -> int:
    """Check every definition, and copy all of them or none."""
    texts = Interfaces.read_folder(options.folder)
    if not texts:
        raise UsageError(f"there is no .msg, .srv or .action file in a folder of that name below {options.folder}")
    known = _interfaces(options).with_texts(texts)
    for key in texts:
        _resolve(known, key)
    for key, text in texts.items():
        path = options.into / f"{key}.{key.split('/')[1]}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    print(f"{len(texts)} types of {', '.join(sorted({key.partition('/')[0] for key in texts}))} are in {options.into}")
    print(f'To use them: interfaces = ["{options.into}"] in the table [ros] of homebot.toml')
    return 0
