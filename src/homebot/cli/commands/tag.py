"""``homebot tag``: ``add`` and ``remove`` for tags of devices; ``read``, ``write``, ``scan`` for NFC tags and codes."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Final, cast

from homebot.cli.arguments import add_verb, add_verbs, duration
from homebot.cli.device_queries import named_device
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.graph_queries import entities
from homebot.devices.names import TAG_DEVICE, TEACH_PLACE, TagNames
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import PeerError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.places_messages import TagDeviceResponse, TeachPlaceResponse
    from homebot.devices.tags import ReadTagResponse, ScanCodeResponse, WriteTagResponse

_EXAMPLES = """\
  homebot tag add 'Kitchen lamp' night
  homebot tag read
  homebot tag write 'Kitchen lamp' --area Kitchen
"""
_TAG_TEXT = """\
  homebot tag add 'Kitchen lamp' night
  homebot tag remove 'Kitchen lamp' night

The directory remembers it across restarts. It writes nothing to an NFC tag; use `homebot tag write` for that.
"""
_SCAN_TEXT = """\
  homebot tag scan homebot:device/kitchen_lamp
  homebot tag scan --teach "$(printf 'Kitchen lamp\\narea: Kitchen')"
"""
_CODES_TEXT = """
Additional exit codes: 3 there is no such reader; 4 no tag appeared in time; 5 the tag cannot be used: too small,
    protected, of another kind, or removed too early.
"""

_NO_READER: Final = 3
_NO_TAG: Final = 4
_UNFIT: Final = 5
_CODES: Final = {"no_reader": _NO_READER, "no_tag": _NO_TAG} | dict.fromkeys(
    ("lost", "not_a_tag", "protected", "too_small", "unreadable"), _UNFIT
)
_MAX_WAIT: Final = 600.0
_GRACE: Final = 10.0
"""Seconds that the gateway may take, besides waiting for the tag."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    add = add_verb(verbs, "add", "tag a device with a word, by which `homebot find tag=WORD` finds it")
    set_door_command(add, partial(_tag, remove=False), _TAG_TEXT, acts=True)
    remove = add_verb(verbs, "remove", "remove a tag from a device")
    set_door_command(remove, partial(_tag, remove=True), _TAG_TEXT, acts=True)
    for command in (add, remove):
        command.add_argument("device", metavar="DEVICE", help="its id or its name")
        command.add_argument("tag", metavar="TAG", help="the tag, one word or several")
    read = add_verb(verbs, "read", "show the device that the tag at the reader, or the next one, points to")
    set_door_command(read, _read, f"  homebot tag read\n{_CODES_TEXT}")
    write = add_verb(verbs, "write", "overwrite the tag at the reader, or the next one, with a pointer to a device")
    set_door_command(write, _write, f"  homebot tag write 'Kitchen lamp' --area Kitchen\n{_CODES_TEXT}", acts=True)
    write.add_argument("device", metavar="DEVICE", help="its id or its name")
    write.add_argument("--area", default="", metavar="ROOM", help="the room of the tag, which is written too")
    scan = add_verb(verbs, "scan", "show the device that a QR code or another text points to")
    set_door_command(scan, _scan, _SCAN_TEXT)
    scan.add_argument("code", metavar="CODE", help="the text of the code")
    scan.add_argument("--teach", action="store_true", help="remember the room in it, if no other source states one")
    scan.add_argument("--gateway", default="nfc", metavar="NAME", help="the gateway of tags (default: nfc)")
    for command in (read, write):
        command.add_argument("--reader", default="", metavar="NAME", help="a part of the reader's name (default: any)")
        command.add_argument("--gateway", default="nfc", metavar="NAME", help="the gateway of tags (default: nfc)")
        command.add_argument(
            "--wait",
            type=partial(duration, most=_MAX_WAIT),
            default=30.0,
            metavar="S",
            help="wait S seconds for a tag (default: 30)",
        )


def _tag(door: DoorClient, options: argparse.Namespace, *, remove: bool) -> int:
    device = named_device(door, options.device).id
    answer = cast("TagDeviceResponse", door.ask(TAG_DEVICE, {"device": device, "tag": options.tag, "remove": remove}))
    print(f"tags of {printable(device)}: {', '.join(map(printable, answer.tags)) or 'none'}")
    return 0


def _read(door: DoorClient, options: argparse.Namespace) -> int:
    request = {"reader": options.reader, "wait": options.wait}
    timeout = options.wait + _GRACE
    answer = cast("ReadTagResponse", _call(door, options.gateway, TagNames(options.gateway).read_tag, request, timeout))
    if not answer.success:
        return _print_failure(answer.problem, answer.message)
    print(f"tag {printable(answer.tag)} ({printable(answer.tag_type)}): {printable(answer.message)}")
    for what, text in (("device", answer.device), ("area", answer.area), ("reader", answer.reader)):
        if text:
            print(f"  {what}: {printable(text)}")
    return 0


def _scan(door: DoorClient, options: argparse.Namespace) -> int:
    request = {"text": options.code}
    response = cast("ScanCodeResponse", _call(door, options.gateway, TagNames(options.gateway).scan, request, _GRACE))
    if not response.success:
        raise PeerError(response.message)
    print(printable(response.message))
    for what, text in (("device", response.device), ("area", response.area)):
        if text:
            print(f"  {what}: {printable(text)}")
    if options.teach:
        if not (response.device and response.area):
            raise PeerError("the code does not name both a device and its room")
        statement = {"device": response.device, "gateway": options.gateway, "room": response.area}
        answer = cast("TeachPlaceResponse", door.ask(TEACH_PLACE, statement))
        print(f"{printable(response.device)} is in {printable(answer.room)} now")
    return 0


def _write(door: DoorClient, options: argparse.Namespace) -> int:
    device = named_device(door, options.device)
    name, timeout = printable(device.name), options.wait + _GRACE
    print(f"hold a tag to the reader; it will point to {name}", flush=True)
    request = {"device": device.id, "area": options.area, "reader": options.reader, "wait": options.wait}
    answer = cast(
        "WriteTagResponse", _call(door, options.gateway, TagNames(options.gateway).write_tag, request, timeout)
    )
    if not answer.success:
        return _print_failure(answer.problem, answer.message)
    print(f"tag {printable(answer.tag)} points to {name} ({printable(answer.device)})")
    return 0


def _call(door: DoorClient, gateway: str, service: str, request: Mapping[str, object], timeout: float) -> JsonMessage:
    try:
        return JsonMessage(door.call(service, request, timeout))
    except PeerError:
        if entities(door, kind="service", name=service):
            raise
        problem = (
            f"no gateway {gateway} that reads tags is running; a table [gateways.nfc] in homebot.toml turns one on"
        )
        raise PeerError(problem) from None


def _print_failure(problem: str, message: str) -> int:
    """Print *message* and return the exit code of a *problem* that has one."""
    code = _CODES.get(problem)
    if code is None:
        raise PeerError(message)
    print(f"homebot: {printable(message)}", file=sys.stderr)
    return code
