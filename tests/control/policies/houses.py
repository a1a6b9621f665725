"""Devices, commands and facts for tests of policies, without a graph."""

from collections.abc import Mapping
from datetime import UTC, tzinfo

from homebot.control.command import IssuedCommand
from homebot.control.policies import Facts, House
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.control.timeline.profile import DeviceProfile
from homebot.devices import Device, DevicePart, Endpoint, Fact, Freshness, State
from homebot.devices.client_rights import APP_RIGHTS
from homebot.devices.device import Route
from homebot.devices.device_view import DeviceView
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue, Value
from homebot.messages import Time
from homebot.words.rights import read_scope

NONE: Mapping[str, PlainValue] = {}

START = 1_800_000_000.0  # 2027-01-15 08:00 UTC


def make_device(
    key: str,
    service_type: str,
    *,
    room: str = "",
    settable: tuple[str, ...] = (),
    tag: str = "",
    freshness: Freshness = "fresh",
    is_live: bool = True,
    since: float = START,
    values: Mapping[str, PlainValue] = NONE,
    facts: tuple[Fact, ...] = (),
    name: str = "",
    approved: str = "",
) -> Device:
    """Return a device of one part with these values; *approved* is the digest of an approved route."""
    names = dict.fromkeys((*settable, *values))
    capabilities = tuple(Capability(name=name, settable=name in settable) for name in names)
    part = Part(id="", service_type=service_type, tag=tag, capabilities=capabilities)
    stamp = Time.from_seconds(since)
    return Device(
        id=key,
        name=name or key,
        service_type=service_type,
        endpoints=(Endpoint(gateway="memory", key=key, address=key, command_address=""),),
        metadata=(),
        first_seen=stamp,
        last_seen=stamp,
        expires=stamp,
        freshness=freshness,
        area=room,
        facts=facts,
        parts=(DevicePart(id="", part=part, routes=(Route(gateway="memory", key=key, part="", approved=approved),)),),
        states=tuple(
            State(part="", capability=name, value=Value.of(value), since=stamp, told_at=stamp, live=is_live)
            for name, value in values.items()
        ),
    )


def make_command(
    device: Device,
    settings: Mapping[str, PlainValue],
    issuer: str = "/app",
    scope: tuple[str, ...] = (),
    name: str = "1",
    at: float = START,
) -> IssuedCommand:
    """Return a command to the only part of *device*, with the id *name*, that was given *at*."""
    return IssuedCommand(
        id=name,
        device=device,
        part=device.parts[0],
        settings=settings,
        issuer=issuer,
        rights=read_scope(scope) if scope else APP_RIGHTS,
        issued_at=at,
    )


def make_facts(*devices: Device, now: float = START, zone: tzinfo = UTC, timeline: PartTimeline | None = None) -> Facts:
    """Return the facts of a house with these devices, and the *timeline* of the commanded part."""
    house = House()
    for device in devices:
        house.put(DeviceView(device, 0))
    house.is_known = True
    return Facts(now, now, zone, house, new_timeline if timeline is None else lambda *_: timeline)


def new_timeline(_device: Device, _part: DevicePart) -> PartTimeline:
    """Return a timeline without facts."""
    return PartTimeline(DeviceProfile(), 10.0, 10.0)
