"""``homebot scene``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Final, cast

from homebot.cli.arguments import add_verb, add_verbs
from homebot.cli.commands.do import add_options_of_commands, command_house
from homebot.cli.device_json import json_text, list_text
from homebot.cli.device_queries import house_time
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.terminal import print_line, print_table
from homebot.cli.text_editor import edited
from homebot.devices.device import target_of
from homebot.devices.names import APPLY_SCENE, CHANGE_SCENE, LIST_SCENES
from homebot.devices.wording.json_message import fields_of
from homebot.devices.wording.time_format import ago
from homebot.errors import PeerError, UsageError
from homebot.support.folding import fold
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.scene_messages import ChangeSceneResponse, SceneInfo, ScenePart, ScenesResponse

_EXAMPLES = """\
  homebot scene list                             the scenes, yours and those that bridges keep
  homebot scene save Film 'lights in living'     take the present values of these
  homebot scene show Film
  homebot scene apply Film --transition 3
  homebot scene undo Film                        bring back what was before, where nobody has changed it since
  homebot scene edit Film 'Kitchen lamp' 'on, 20 %, 2700 K'
  homebot scene edit Film --without 'Hall lamp'
  homebot scene edit Film                        the same in your editor ($EDITOR)
  homebot scene rename Film Cinema
  homebot scene remove Cinema

Values are the words of `homebot do`. A scene that a bridge or device keeps is listed, shown, applied and
undone like yours. Exit code 0 means that every device obeyed, or was already so. `save`, `edit`, `rename` and
`remove` need the right `manage`.
"""
_TEXT: Final = "# One device and its values in each line, as for `homebot do`; without its line, it is left out.\n"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list the scenes")
    set_door_command(command, _list, _EXAMPLES)
    command.add_argument("--json", action="store_true", help="print a JSON list")
    command = _with_name(add_verb(verbs, "show", "show the values of a scene"))
    set_door_command(command, show, _EXAMPLES)
    command.add_argument("--json", action="store_true", help="print a JSON object")
    command = _with_name(add_verb(verbs, "save", "save the present values of devices as a scene"))
    set_door_command(command, _save, _EXAMPLES, acts=True)
    command.add_argument(
        "target", metavar="QUERY", nargs="?", default="", help="the devices; for a known scene, by default its own"
    )
    for verb, summary in (("apply", "apply a scene"), ("undo", "bring back what was before a scene")):
        command = _with_name(add_verb(verbs, verb, summary))
        set_door_command(command, partial(_apply, undo=verb == "undo"), _EXAMPLES, acts=True)
        add_options_of_commands(command)
        command.add_argument("--yes", action="store_true", help="agree to what it sets on devices that always ask")
    command = _with_name(add_verb(verbs, "edit", "change the values of a scene"))
    set_door_command(command, _edit, _EXAMPLES, acts=True)
    command.add_argument("target", metavar="QUERY", nargs="?", default="", help="the devices whose values change")
    command.add_argument("values", metavar="VALUES", nargs="?", default="", help="their values, such as 'on, 20 %%'")
    command.add_argument("--without", metavar="QUERY", action="append", default=[], help="leave these devices out")
    command = _with_name(add_verb(verbs, "rename", "rename a scene"))
    set_door_command(command, _rename, _EXAMPLES, acts=True)
    command.add_argument("target", metavar="NEW", help="its new name")
    command = _with_name(add_verb(verbs, "remove", "forget a scene"))
    set_door_command(command, _remove, _EXAMPLES, acts=True)


def _with_name(command: argparse.ArgumentParser) -> argparse.ArgumentParser:
    command.add_argument("name", metavar="NAME", help="its name")
    return command


def _scenes(door: DoorClient, name: str = "") -> tuple[SceneInfo, ...]:
    return cast("ScenesResponse", door.ask(LIST_SCENES, {"name": name})).scenes


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    scenes = _scenes(door)
    if options.json:
        print(list_text([json_text(fields_of(scene)) for scene in scenes]))
    elif scenes:
        rows = [
            (printable(scene.name), printable(scene.area), _kind(scene), str(len(scene.parts) or "?"))
            for scene in scenes
        ]
        print_table(("SCENE", "ROOM", "KEPT BY", "PARTS"), rows, if_any=("ROOM",))
    else:
        print("there is no scene; `homebot scene save NAME QUERY` makes one of the present values")
    return 0


def _kind(scene: SceneInfo) -> str:
    if scene.is_configured:
        return "configuration"
    return printable(scene.id.partition("#")[0]) if scene.is_native else "homebot"


def show(door: DoorClient, options: argparse.Namespace) -> int:
    """Print the scene of the name in *options*, and when it was last applied."""
    scene = _scenes(door, options.name)[0]
    if options.json:
        print(json_text(fields_of(scene)))
        return 0
    print_line(f"{printable(scene.name)}, kept by {printable(scene.id) if scene.is_native else _kind(scene)}")
    for part in scene.parts:
        print_line(f"  {_part_text(part)}")
    for item in scene.problems:
        print_line(f"  {printable(item.key)}: {printable(item.value, 300)}")
    if scene.applied_at.sec:
        undone = "" if scene.can_undo else ", and undone since"
        print_line(f"  applied {ago(scene.applied_at, house_time(door))}{undone}")
    return 0


def _part_text(part: ScenePart) -> str:
    asks = f" (always asks: {printable(part.asks)})" if part.asks else ""
    absent = "" if part.is_known else " (not in the house now)"
    return f"{printable(part.name)}: {printable(part.text, 300) or 'as its source says'}{asks}{absent}"


def _apply(door: DoorClient, options: argparse.Namespace, *, undo: bool) -> int:
    asking = [] if undo else [part for part in _scenes(door, options.name)[0].parts if part.asks]
    agreed = options.yes or _agrees(asking)
    request = {"name": options.name, "transition": options.transition, "undo": undo, "agreed": agreed}
    return command_house(door, options, APPLY_SCENE, request)


def _agrees(asking: list[ScenePart]) -> bool:
    """Return whether the person agrees to *asking*; without a terminal, homebot asks people in the house."""
    if not asking or not sys.stdin.isatty():
        return False
    for part in asking:
        print(_part_text(part))
    if input("Do that? [y/N] ").strip().casefold() not in {"y", "yes"}:
        raise UsageError("nothing was sent")
    return True


def _save(door: DoorClient, options: argparse.Namespace) -> int:
    name = fold(options.name.strip())
    if any(scene.is_configured and fold(scene.name) == name for scene in _scenes(door)):
        raise UsageError(
            f"the configuration has a scene {options.name!r}, which this would hide; change it there, and "
            "`homebot reload`, or choose another name"
        )
    answer = _change(door, options, "save")
    for item in answer.left_out:
        print(f"left out: {printable(item.key)}: {printable(item.value, 300)}", file=sys.stderr)
    return 0


def _change(door: DoorClient, options: argparse.Namespace, change: str, **more: object) -> ChangeSceneResponse:
    request = {"name": options.name, "change": change, "target": getattr(options, "target", ""), **more}
    answer = cast("ChangeSceneResponse", door.ask(CHANGE_SCENE, request))
    for scene in answer.scenes:
        print_line(f"{printable(scene.name)} has {len(scene.parts)} part{'s' * (len(scene.parts) != 1)}:")
        for part in scene.parts:
            print_line(f"  {_part_text(part)}")
    return answer


def _edit(door: DoorClient, options: argparse.Namespace) -> int:
    if options.target and not options.values:
        raise UsageError("give the values too, such as 'on, 20 %', or --without to leave devices out")
    values = dict.fromkeys(options.without, "") | ({options.target: options.values} if options.target else {})
    if values:
        return _send(door, options, values)
    scene = _scenes(door, options.name)[0]
    if scene.is_native or scene.is_configured:
        raise UsageError(f"{scene.name} is kept by {scene.id if scene.is_native else _kind(scene)}; change it there")
    before = {target_of(part.device, part.part): part.text for part in scene.parts}
    lines = (f"# {printable(part.name)}\n{target_of(part.device, part.part)}: {part.text}\n" for part in scene.parts)
    text, path = edited(_TEXT + "".join(lines))
    try:
        _send(door, options, _differences(before, text))
    except (PeerError, UsageError) as exc:
        raise UsageError(f"{exc}; your text is in {path}") from exc
    path.unlink()
    return 0


def _send(door: DoorClient, options: argparse.Namespace, values: Mapping[str, str]) -> int:
    _change(door, options, "edit", target="", values=[{"key": key, "value": value} for key, value in values.items()])
    return 0


def _differences(before: Mapping[str, str], text: str) -> dict[str, str]:
    """Return the values by target that a person changed, without any where the line was removed."""
    after: dict[str, str] = {}
    for line in text.splitlines():
        if line.strip() and not line.startswith("#"):
            target, divider, words = line.partition(": ")
            if not (divider and words.strip()):
                raise UsageError(f"{line[:100]!r}: write a device and its values, such as 'hall_lamp: on, 20 %'")
            after[target.strip()] = words.strip()
    changed = {target: words for target, words in after.items() if words != before.get(target)}
    return {**{target: "" for target in before if target not in after}, **changed}


def _rename(door: DoorClient, options: argparse.Namespace) -> int:
    _change(door, options, "rename")
    return 0


def _remove(door: DoorClient, options: argparse.Namespace) -> int:
    _change(door, options, "remove")
    print(f"removed {printable(options.name)}")
    return 0
