"""Statements of the owner: ``alias``, ``approve``, ``forget``, ``merge``, ``pair``, ``place``, ``split``, ``trust``.

The directory remembers them across restarts.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, TypeAlias, cast

from homebot.cli.arguments import set_client_command
from homebot.cli.device_queries import device_or_similar, named_device, unapproved
from homebot.cli.door_client import DoorClient, set_door_command, with_client
from homebot.cli.graph_queries import entities
from homebot.cli.publishing import GatewayPublisher
from homebot.devices.names import (
    ALIAS_DEVICE,
    APPROVE_DEVICE,
    FORGET_DEVICE,
    MERGE_DEVICES,
    PLACE_DEVICE,
    SPLIT_DEVICE,
    TRUST_DEVICE,
    PairingNames,
)
from homebot.errors import PeerError, UsageError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import Device
    from homebot.devices.approval_messages import ApproveDeviceResponse
    from homebot.devices.places_messages import AliasDeviceResponse, PlaceDeviceResponse
    from homebot.devices.services import ForgetDeviceResponse, MergeDevicesResponse, SplitDeviceResponse

_Statement: TypeAlias = "Callable[[DoorClient, Device, argparse.Namespace], None]"

_PAIRED_WITHIN: Final = 90.0
"""Seconds; a sleeping device has to wake up, and some wait for a button press."""


def add_alias_arguments(parser: argparse.ArgumentParser) -> None:
    _set_command(
        parser,
        _alias,
        """\
  homebot alias lights/roomlights405 'Ceiling lamp'
  homebot alias 'Ceiling lamp' 'Ceiling lamp' --undo

The newest alias is shown as its name; the device is still found by its other names. The directory remembers it across
restarts.
""",
    )
    parser.add_argument("name", metavar="NAME", help="the additional name")
    parser.add_argument("--undo", action="store_true", help="remove the name")


def add_approve_arguments(parser: argparse.ArgumentParser) -> None:
    _set_command(
        parser,
        _approve,
        """\
  homebot approve 'Front door' --show      only show what would be approved
  homebot approve 'Front door'
  homebot approve 'Front door' --undo

Locks, garage doors, ovens, boilers, valves and alarm panels wait for this: until then nothing is sent to them.
`homebot devices` shows which ones wait. It prints what is approved: each setting with its topic and payload. If the
device announces another type, topic, payload or identifier, it waits again. Approvals survive restarts.
""",
    )
    action = parser.add_mutually_exclusive_group()
    action.add_argument("--show", action="store_true", help="show what would be approved, without changing anything")
    action.add_argument("--undo", action="store_true", help="withdraw the approval")


def add_forget_arguments(parser: argparse.ArgumentParser) -> None:
    _set_command(
        parser,
        _forget,
        """\
  homebot forget lights/roomlights405
  homebot forget 'Kitchen lamp' --purge

A forgotten device comes back when it sends a message or is announced again.
""",
    )
    parser.add_argument(
        "--purge",
        action="store_true",
        help="also delete its retained announcements from the broker, so that no program finds it any more",
    )


def add_merge_arguments(parser: argparse.ArgumentParser) -> None:
    examples = """\
  homebot merge 'Kitchen lamp' 'Kitchen lamp 2'
  homebot merge 'Kitchen lamp'                    # send commands to all its endpoints (homebot show)

The directory remembers it across restarts; `homebot split` undoes it.
"""
    set_door_command(parser, _merge, examples, acts=True)
    parser.add_argument(
        "devices",
        nargs="+",
        metavar="DEVICE",
        help="ids or names of two or more devices, or of one whose endpoints all belong to it",
    )


def add_pair_arguments(parser: argparse.ArgumentParser) -> None:
    examples = """\
  homebot pair 'Hall lamp' 123-45-678     with the code on the device
  homebot pair 'Hue bridge'               after pressing the button on the device
  homebot pair --remove 'Hall lamp'

Some devices serve only paired programs. homebot stores the resulting key in a file that only its own user can read; the
code is not stored. It needs the right `manage`. `homebot doctor` names devices that wait for pairing.
"""
    _set_command(parser, _pair, examples)
    parser.add_argument("code", metavar="CODE", nargs="?", default="", help="the code on the device, if it has one")
    parser.add_argument("--remove", action="store_true", help="end the pairing")


def add_place_arguments(parser: argparse.ArgumentParser) -> None:
    examples = """\
  homebot place 'Kitchen lamp' Kitchen
  homebot place 'Kitchen lamp' --at 3.2,1.0
  homebot place 'Kitchen lamp' --undo

A position is in metres, as in the polygons of rooms; without a ROOM the device is in the room at that position. An
absent device, by its name, id or hardware address (mac:a4cf12f04ab1), is placed when it appears. The directory
remembers it across restarts. It takes precedence over the room that the device announces, and the one in the
configuration; `homebot show` lists all sources. `homebot places list` lists the rooms.
"""
    set_client_command(parser, _place, examples, acts=True)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument("room", nargs="?", default="", metavar="ROOM", help="its room or floor")
    parser.add_argument("--at", default="", metavar="X,Y[,FLOOR]", help="its position, in metres")
    parser.add_argument("--undo", action="store_true", help="withdraw the statement of this command or of an import")
    parser.add_argument(
        "--new", action="store_true", help="ROOM, or an absent DEVICE, is not the one with a similar name"
    )


def add_split_arguments(parser: argparse.ArgumentParser) -> None:
    _set_command(
        parser,
        _split,
        """\
  homebot show 'Kitchen lamp'                     # lists its announcements, and the reasons why they are one device
  homebot split 'Kitchen lamp'                    # each of them becomes a device of its own
  homebot split 'Kitchen lamp' mdns Lamp._wled._tcp.local.    # only this one becomes another device

The directory remembers it across restarts; `homebot merge` undoes it.
""",
    )
    parser.add_argument("gateway", nargs="?", default="", metavar="GATEWAY", help="the gateway of one announcement")
    parser.add_argument("key", nargs="?", default="", metavar="KEY", help="its key there")


def add_trust_arguments(parser: argparse.ArgumentParser) -> None:
    _set_command(
        parser,
        _trust,
        """\
  homebot trust 'Hall lamp'

For a device that a sensor contradicted although it obeys, for example because it was repaired. It is trusted
automatically once the sensor sees it obey. It needs the right `manage`. `homebot doctor` names such devices.
""",
    )


def _set_command(parser: argparse.ArgumentParser, statement: _Statement, examples: str) -> None:
    """Make *parser* run *statement* about its first argument, a device."""

    def state(door: DoorClient, options: argparse.Namespace) -> int:
        statement(door, named_device(door, options.device), options)
        return 0

    set_door_command(parser, state, examples, acts=True)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")


def _alias(door: DoorClient, device: Device, options: argparse.Namespace) -> None:
    request = {"device": device.id, "alias": options.name, "remove": options.undo}
    answer = cast("AliasDeviceResponse", door.ask(ALIAS_DEVICE, request))
    print(f"aliases of {printable(device.id)}: {', '.join(map(printable, answer.aliases)) or 'none'}")


def _approve(door: DoorClient, device: Device, options: argparse.Namespace) -> None:
    def ask(**request: object) -> ApproveDeviceResponse:
        return cast("ApproveDeviceResponse", door.ask(APPROVE_DEVICE, {"device": device.id, **request}))

    waited = device.id in unapproved(door, device.id)
    answer = shown = ask(is_preview=not options.undo, remove=options.undo)
    if options.show:
        state = f"{'waits' if waited else 'does not wait'} for approval; its commands:"
    elif options.undo:
        state = "is not approved any more"
    else:  # approves exactly what is printed, even if the device keeps changing
        answer = ask(digest=shown.digest)
        state = "is approved" if waited else "is approved; it was not waiting for that"
    print(f"{printable(device.id)} {state}")
    for change in answer.changes:
        print(f"  changed: {printable(change)}")
    for command in shown.commands:
        print(f"  {printable(command)}")


def _forget(door: DoorClient, device: Device, options: argparse.Namespace) -> None:
    publisher = GatewayPublisher(door)
    if options.purge:  # before anything is changed, so that nothing is half done
        for gateway in sorted({endpoint.gateway for endpoint in device.endpoints}):
            publisher.check(gateway)
    answer = cast("ForgetDeviceResponse", door.ask(FORGET_DEVICE, {"device": device.id}))
    returns = "" if options.purge else "; it comes back when it sends a message or is announced again"
    print(f"forgot {printable(device.id)}{returns}")
    for announcement in answer.announced_on:
        topic = printable(announcement.topic)
        if options.purge:
            publisher.publish(announcement.gateway, announcement.topic, "")
            print(f"deleted the retained message on {topic}")
        else:
            print(f"it was announced on {topic}; --purge deletes the retained message there")


def _merge(door: DoorClient, options: argparse.Namespace) -> int:
    ids = [named_device(door, name).id for name in options.devices]
    answer = cast("MergeDevicesResponse", door.ask(MERGE_DEVICES, {"devices": ids}))
    if len(ids) == 1:
        print(f"all endpoints of {printable(answer.device)} get its commands now")
    else:
        print(f"{', '.join(map(printable, ids))} are one device now: {printable(answer.device)}")
    return 0


def _pair(door: DoorClient, device: Device, options: argparse.Namespace) -> None:
    if options.remove and options.code:
        raise UsageError("--remove takes no code")
    served = {entity.name for entity in entities(door, kind="service")}
    endpoint = next(
        (candidate for candidate in device.endpoints if PairingNames(candidate.gateway).pair in served), None
    )
    if endpoint is None:
        raise PeerError(f"{printable(device.id)} needs no pairing: no running gateway that knows it pairs devices")
    names, request = PairingNames(endpoint.gateway), {"device": endpoint.key}
    if options.remove:
        answer = door.ask(names.unpair, request, _PAIRED_WITHIN)
    else:
        answer = door.ask(names.pair, request | {"code": options.code}, _PAIRED_WITHIN)
    print(f"{printable(str(answer.name))} is {'not paired any more' if options.remove else 'paired'}")


def _place(options: argparse.Namespace) -> int:
    if options.undo is bool(options.room or options.at):
        raise UsageError("give either a ROOM, --at, or both, or --undo")
    return with_client(options, _place_at)


def _place_at(door: DoorClient, options: argparse.Namespace) -> int:
    known = device_or_similar(door, options.device)
    is_absent = isinstance(known, list)
    if isinstance(known, list) and known and not options.undo and not options.new:
        hint = "For another device, which is absent now, add --new"
        raise PeerError(f"there is no device {options.device}; did you mean {' or '.join(known)}? {hint}")
    device = options.device if isinstance(known, list) else known.id
    request = {"device": device, "room": options.room, "is_new": options.new, "may_be_absent": is_absent}
    try:
        answer = cast("PlaceDeviceResponse", door.ask(PLACE_DEVICE, request | {"at": options.at}))
    except PeerError as exc:
        hint = "" if options.new or "did you mean" not in str(exc) else " For another room, add --new"
        raise PeerError(f"{exc}{hint}") from exc
    print(_placed_text(printable(device), printable(options.at), answer))
    return 0


def _placed_text(device: str, position: str, answer: PlaceDeviceResponse) -> str:
    room, absent = printable(answer.room), printable(answer.absent)
    where = " ".join([f"at {position}"] * bool(position) + [f"in {room}"] * bool(room))
    if absent:
        later = f"will be {where} when it appears" if where else "will be in no stated room"
        return f"there is no device {device} yet; {absent} {later}"
    if position and not room:
        return f"{device} is {where} now; its room is unknown"
    return f"{device} is {where} now" if where else f"the room of {device} is unknown now"


def _split(door: DoorClient, device: Device, options: argparse.Namespace) -> None:
    request = {"device": device.id, "gateway": options.gateway, "key": options.key}
    ids = [printable(device_id) for device_id in cast("SplitDeviceResponse", door.ask(SPLIT_DEVICE, request)).devices]
    print(f"{ids[0]} is {len(ids)} devices now: {', '.join(ids)}")


def _trust(door: DoorClient, device: Device, _: argparse.Namespace) -> None:
    witnesses = cast("list[str]", door.call(TRUST_DEVICE, {"device": device.id})["witnesses"])
    for name in witnesses:
        print(f"{printable(device.id)} is trusted again; {printable(name)} had measured no change")
    if not witnesses:
        print(f"{printable(device.id)} was trusted already")
