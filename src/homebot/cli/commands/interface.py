"""``homebot interface list``, ``show``, ``find`` and ``import``."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from homebot.bridges.rosbridge.types import OWN_MODULES
from homebot.cli.arguments import DEFAULT_CONFIG, Command, add_verb, add_verbs, set_command
from homebot.config import load_config
from homebot.errors import UnknownTypeError, UsageError
from homebot.messages.definition import fields_of
from homebot.messages.interfaces import Interfaces
from homebot.messages.interfaces.interface_classes import Interface, messages_in
from homebot.messages.interfaces.settings import read_interfaces
from homebot.messages.type_hash import type_hash

__all__ = ["add_arguments"]

_EXAMPLES = """\
  homebot interface list nav2_msgs
  homebot interface show nav2_msgs/action/NavigateToPose
  homebot interface find requester_id
  homebot interface import ~/ros2_ws/src
"""
_KINDS: Final = ("msg", "srv", "action")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the commands below ``homebot interface``."""
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list messages, services and actions")
    command.add_argument("package", metavar="PACKAGE", nargs="?", default="", help="only those of this package")
    _add(command, _list)
    command = add_verb(verbs, "show", "print the definition of a type, and its hash in ROS 2")
    command.add_argument("type", metavar="TYPE", help="PACKAGE/msg/NAME, with srv or action for those")
    _add(command, _show)
    command = add_verb(verbs, "find", "list the types with a word in their name, or with a field of that name or type")
    command.add_argument("word", metavar="WORD", help="part of the type's name, or a whole field")
    _add(command, _find)
    command = add_verb(verbs, "import", "check and copy the definitions of a workspace, for the table [ros]")
    command.add_argument("folder", metavar="DIR", type=Path, help="folder with packages in it, at any depth")
    command.add_argument(
        "--into", metavar="DIR", type=Path, default=Path("interfaces"), help="where they go (default: interfaces)"
    )
    _add(command, _import)


def _add(parser: argparse.ArgumentParser, command: Command) -> None:
    set_command(parser, command, _EXAMPLES)
    parser.add_argument(
        "--config",
        metavar="FILE",
        type=Path,
        help="whose table [ros] counts too (default: homebot.toml, if it is there)",
    )


def _interfaces(options: argparse.Namespace) -> Interfaces:
    path = options.config or (DEFAULT_CONFIG if DEFAULT_CONFIG.exists() else None)
    known = read_interfaces(load_config(path).ros if path else {}, str(path), path.parent if path else Path())
    known.add_modules("homebot", OWN_MODULES)
    return known


def _list(options: argparse.Namespace) -> int:
    """Print the names of interfaces, one a line."""
    names = _interfaces(options).names(options.package)
    if not names:
        raise UsageError(f"there is no package {options.package!r}; homebot interface list shows all")
    print("\n".join(names))
    return 0


def _show(options: argparse.Namespace) -> int:
    """Print the text of a type, and its hash as a comment."""
    known = _interfaces(options)
    kind, interface = _resolve(known, options.type)
    print(f"# {interface.ros_type}\n# {type_hash(interface)}\n{known.text(interface.ros_type, kind)}", end="")
    return 0


def _resolve(known: Interfaces, ros_type: str) -> tuple[str, Interface]:
    """Return the interface called *ros_type*, of the first kind that has the name, and the kind.

    Raises:
        UnknownTypeError: No kind has it; the error is that of the kind with similar names, if there is one.
    """
    finders: tuple[Callable[[str], Interface], ...] = (known.find_message, known.find_service, known.find_action)
    unknown: list[UnknownTypeError] = []
    for kind, find in zip(_KINDS, finders, strict=True):
        try:
            return kind, find(ros_type)
        except UnknownTypeError as exc:
            unknown.append(exc)
    raise max(unknown, key=lambda error: len(str(error)))


def _find(options: argparse.Namespace) -> int:
    """Print the names of types by a word; return 1 if there are none."""
    known, word = _interfaces(options), options.word.lower()

    def words(name: str) -> Iterator[str]:
        for message in messages_in(_resolve(known, name)[1]):
            for field in fields_of(message):
                yield from (field.name, *field.declaration.lower().split(" "))

    names = [name for name in known.names() if word in name.lower() or word in words(name)]
    print(
        "\n".join(names)
        if names
        else f"no type has {options.word!r} in its name, and none a field of that name or type"
    )
    return 0 if names else 1


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
