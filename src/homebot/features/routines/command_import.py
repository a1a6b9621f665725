"""``homebot routine import``: prints automations of another program as routines, and lists all that it leaves out."""

import sys

from homebot.cli.device_queries import all_devices
from homebot.cli.door_client import DoorClient
from homebot.cli.text_editor import read_text
from homebot.errors import UsageError, WireError
from homebot.features.routines.text import read_routines
from homebot.plugins import check_extra, load_plugin, plugin_names
from homebot.support.printable import printable
from homebot.words.automations import IMPORTERS, AutomationReader


def import_routines(door: DoorClient, file: str) -> int:
    """Print the routines of *file*, and to standard error the lines that were not carried over; return the exit code.

    Raises:
        UsageError: It cannot be read, or has no automations.
    """
    check_extra("`homebot routine import`", "maps", "yaml")
    from homebot.cli.yaml_loader import load_located  # noqa: PLC0415 - an extra

    if not (names := plugin_names(IMPORTERS)):
        raise UsageError("no installed package reads automations of another program")
    try:
        document = load_located(read_text(file))
    except WireError as exc:
        raise UsageError(f"{file} cannot be read: {exc}") from exc
    reader: AutomationReader = load_plugin(IMPORTERS, names[0])()
    found = reader.read(
        document, file, all_devices(door, lambda one: one), lambda text, origin: read_routines(text, origin)[0]
    )
    for line in "\n".join(found.texts).splitlines():
        print("".join(one if one.isprintable() else f"\\U{ord(one):08x}" for one in line))  # as in texts of TOML
    for one in sorted(found.refused):
        print(
            f"{printable(file)}, line {one.line}, {printable(one.name)}: {printable(one.problem, 500)}", file=sys.stderr
        )
    left_out = len({one.name for one in found.refused})
    carried = f"{found.total - left_out} of {found.total} automations are carried over"
    advice = "" if not found.texts else "; look at each, then: homebot routine try FILE, homebot routine new FILE"
    print(f"{carried}{advice}", file=sys.stderr)
    return 0 if found.texts else 1
