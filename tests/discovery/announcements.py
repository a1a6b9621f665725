"""Announcements of described devices, their parts and their reports."""

from itertools import islice
from typing import Literal

from homebot.devices import Device, KeyValue, Sighting
from homebot.devices.gateway_messages import Report
from homebot.devices.part import Capability, Category, Part
from homebot.devices.value import PlainValue, Reading, Value
from homebot.discovery import DeviceIndex
from homebot.messages import Time

WHOLE_DEVICE = frozenset({"homie", "shelly", "tasmota", "zigbee2mqtt"})
"""Conventions whose announcements are each of a whole device, and the devices' own."""


def announce(
    key: str,
    *parts: Part,
    convention: str = "homeassistant",
    ids: tuple[str, ...] = (),
    name: str = "Desk lamp",
    gateway: str = "mqtt",
    area: str = "",
    facts: dict[str, str] | None = None,
    at: float = 0.0,
    confirmed: bool = False,
    kind: Literal["appeared", "updated", "removed"] = "updated",
    owns: tuple[str, ...] = (),
    on: str | None = None,
) -> Sighting:
    return Sighting(
        gateway=gateway,
        key=f"{convention}:{key}",
        kind=kind,
        why="it was announced",
        name=name,
        service_type=parts[0].service_type if parts else "x_unknown",
        address="",
        command_address="",
        metadata=tuple(KeyValue(key=one, value=value) for one, value in (facts or {}).items()),
        convention=convention,
        native=convention in WHOLE_DEVICE,
        whole_device=convention in WHOLE_DEVICE,
        identifiers=ids,
        area=area,
        parts=parts,
        announced_on=f"{convention}/{key}{_named_by(ids)}/config" if on is None else on,
        owns=owns,
        seen_at=Time.from_seconds(at),
        expires_at=Time.from_seconds(at + 3600),
        confirmed=confirmed,
    )


def _named_by(ids: tuple[str, ...]) -> str:
    """Bridges announce a device at a place that has its hardware address."""
    found = (one.partition(":")[2] for one in ids if not one.startswith("id:"))
    return "".join(f"/{one}" for one in islice(found, 1))


def part_of(
    service_type: str = "light",
    *capabilities: str,
    id: str = "",  # noqa: A002 - as the part calls it
    name: str = "",
    writes: tuple[str, ...] = (),
    reads: tuple[str, ...] = (),
    category: Category = "",
    tag: str = "",
    advertised: str = "",
    guessed: bool = False,
) -> Part:
    return Part(
        id=id,
        name=name,
        service_type=service_type,
        capabilities=tuple(Capability(name=one, settable=bool(writes)) for one in capabilities),
        writes=writes,
        reads=reads,
        category=category,
        tag=tag,
        advertised=advertised,
        guessed=guessed,
    )


def tell(
    sighting: Sighting,
    capability: str,
    value: PlainValue,
    *,
    part: str = "",
    at: float = 1.0,
    retained: bool = False,
    address: str = "said",
) -> Report:
    """A report of one value."""
    return Report(
        gateway=sighting.gateway,
        key=sighting.key,
        readings=(Reading(part=part, capability=capability, value=Value.of(value)),),
        address=address,
        stream=f"{sighting.key} {address}",
        retained=retained,
        received_at=Time.from_seconds(at),
    )


def only_device(index: DeviceIndex) -> Device:
    (device,) = index.devices()
    return device


def contents(device: Device) -> frozenset[object]:
    """Return its parts without their ids, which depend on the order of announcements."""
    return frozenset(
        (
            frozenset((way.key, way.part, way.takes) for way in one.routes),
            one.part.service_type,
            one.part.category,
            frozenset(one.part.capabilities),
        )
        for one in device.parts
    )
