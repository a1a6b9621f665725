"""``homebot routine import``: prints automations of another program as routines, and lists all that it leaves out."""

import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, cast

from homebot.cli.device_queries import all_devices
from homebot.cli.door_client import DoorClient
from homebot.cli.text_editor import read_text
from homebot.devices.names import LIST_ROUTINES, LIST_SCENES
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import PeerError, UsageError, WireError
from homebot.features.routines.text import read_routines
from homebot.plugins import check_extra, load_plugin, plugin_names
from homebot.support.located import Located
from homebot.support.printable import printable
from homebot.words.automations import IMPORTERS, AutomationReader

if TYPE_CHECKING:
    from homebot.devices.app_messages import RoutinesResponse
    from homebot.devices.scene_messages import ScenesResponse


def import_routines(door: DoorClient, file: str, blueprint: str = "") -> int:
    """Print the routines of *file*, and to standard error the lines that were not carried over; return the exit code.

    Args:
        blueprint: The file of the blueprint that its automations use; empty for none.

    Raises:
        UsageError: It cannot be read, or has no automations.
    """
    check_extra("`homebot routine import`", "maps", "yaml")
    from homebot.cli.yaml_loader import load_located  # noqa: PLC0415 - an extra

    if not (names := plugin_names(IMPORTERS)):
        raise UsageError("no installed package reads automations of another program")

    def load(path: str) -> Located:
        try:
            return load_located(read_text(path))
        except WireError as exc:
            raise UsageError(f"{path} cannot be read: {exc}") from exc

    folder = Path(file).parent.resolve()

    def load_beside(path: str) -> Located:
        if not (beside := (folder / path).resolve()).is_relative_to(folder):
            raise UsageError(f"{path} is not in the folder of {file}")
        return load(str(beside))

    reader: AutomationReader = load_plugin(IMPORTERS, names[0])()
    found = reader.read(
        load(file),
        file,
        all_devices(door, lambda one: one),
        lambda text, origin: read_routines(text, origin)[0],
        scenes=_scenes(door),
        routines=_routines(door),
        load=load_beside,
        blueprint=load(blueprint) if blueprint else None,
    )
    for line in "\n".join(found.texts).splitlines():
        print("".join(one if one.isprintable() else f"\\U{ord(one):08x}" for one in line))  # as in texts of TOML
    for one in sorted(found.refused):
        print(
            f"{printable(file)}, line {one.line}, {printable(one.name)}: {printable(one.problem, 500)}", file=sys.stderr
        )
    left_out = len({one.name for one in found.refused})
    noted = sum("\n# note: " in text for text in found.texts)
    counts = f"{found.total - left_out} of {found.total} automations are carried over"
    advice = "" if not found.texts else "; look at each, then: homebot routine try FILE, homebot routine new FILE"
    print(f"{counts}, {noted} with a note; {left_out} refused{advice}", file=sys.stderr)
    return 0 if found.texts else 1


def _scenes(door: DoorClient) -> list[str]:
    """Return the names of the owner's scenes; none without this feature."""
    with suppress(PeerError):
        answer = cast("ScenesResponse", JsonMessage(door.call(LIST_SCENES, {})))
        return [scene.name for scene in answer.scenes if not scene.is_native]
    return []


def _routines(door: DoorClient) -> list[str]:
    """Return the names of the routines of the house; none without an answer."""
    with suppress(PeerError):
        answer = cast("RoutinesResponse", JsonMessage(door.call(LIST_ROUTINES, {})))
        return [routine.name for routine in answer.routines]
    return []
