"""Questions of the command line to the directory."""

from __future__ import annotations

from pydantic import BaseModel, field_validator

from homebot.cli.door_client import DoorClient
from homebot.cli.table import printable
from homebot.cli.terminal import progress
from homebot.devices import FIND_DEVICES, QUERY_DEVICES, Device
from homebot.devices.query import quoted
from homebot.devices.query.folding import fold
from homebot.devices.services import FindDevicesResponse, QueryDevicesResponse
from homebot.errors import PeerError
from homebot.messages import Time
from homebot.messages.json import message_from_json
from homebot.similar import did_you_mean

__all__ = ["all_devices", "find_devices", "house_time", "named_device", "reasons_for"]

_NEAR = 100

_PAGE = 200
"""Devices in one answer: homebot does nothing else while it spells one out, and a whole house may take seconds."""

_ROUNDS = 3
"""Times that all pages are asked for, should devices change places in between so that one slips through."""


async def all_devices(door: DoorClient, service_type: str = "") -> tuple[Device, ...]:
    """Return the devices that offer *service_type*, sorted by id; all where it is empty."""
    if service_type:
        answer = await door.call(FIND_DEVICES, {"service_type": service_type})
        return message_from_json(FindDevicesResponse, answer).devices
    found: dict[str, Device] = {}
    for _ in range(_ROUNDS):
        page = await find_devices(door, "", _PAGE)
        found |= {one.device.id: one.device for one in page.results}
        with progress("devices", page.total if page.total > _PAGE else 0) as show:
            for offset in range(_PAGE, page.total, _PAGE):
                page = await find_devices(door, "", _PAGE, offset)
                found |= {one.device.id: one.device for one in page.results}
                show(len(found))
        if len(found) >= page.total:
            break
    return tuple(found[one] for one in sorted(found))


async def find_devices(door: DoorClient, query: str, limit: int = 0, offset: int = 0) -> QueryDevicesResponse:
    """Return what fits *query*, best first; *limit* at most, without the *offset* best.

    Raises:
        PeerError: The query is not understood; the message says what of it.
    """
    answer = await door.call(QUERY_DEVICES, {"query": query, "offset": offset, "limit": limit})
    found = message_from_json(QueryDevicesResponse, answer)
    if not found.success:
        raise PeerError(found.message)
    return found


async def named_device(door: DoorClient, name: str) -> Device:
    """Return the one device whose id or name *name* is, whatever the case and accents of a name.

    Raises:
        PeerError: There is none, with similar ones named, or there are several, all named.
    """
    named = _called(name, await _near(door, name))
    if len(named) == 1:
        return named[0]
    devices = await all_devices(door)
    named = _called(name, devices)
    if len(named) == 1:
        return named[0]
    if named:
        raise PeerError(
            f"{len(named)} devices are called {name}; give the id of one: "
            + ", ".join(printable(one.id) for one in named[:10])
        )
    known = [printable(text) for one in devices for text in (one.id, one.name)]
    raise PeerError(f"there is no device {name}; {did_you_mean(name, known, '`homebot devices` lists all')}")


async def _near(door: DoorClient, name: str) -> tuple[Device, ...]:
    """Return the devices that a search for *name* finds, without carrying a whole house; none where they are many."""
    answer = await door.call(QUERY_DEVICES, {"query": quoted(name), "offset": 0, "limit": _NEAR})
    found = message_from_json(QueryDevicesResponse, answer)
    return tuple(one.device for one in found.results) if found.total <= _NEAR else ()


def _called(name: str, devices: tuple[Device, ...]) -> list[Device]:
    """The one whose id *name* is, or all that are called so."""
    wanted = fold(name)
    own = [one for one in devices if one.id == name]
    return own or [one for one in devices if wanted in {fold(text) for text in (one.id, one.name, *one.names)}]


async def reasons_for(door: DoorClient, device: Device) -> tuple[str, ...]:
    """Return why a search for the device's name finds it, and why it stands where it stands."""
    found = await find_devices(door, quoted(device.name))
    return next((one.reasons for one in found.results if one.device.id == device.id), ())


async def house_time(door: DoorClient) -> float:
    """Return what time it is for homebot, in seconds since 1970."""
    answer = await door.call("/rosapi/get_time")
    return _Now.model_validate(answer).time.to_seconds()


class _Now(BaseModel):
    """The answer has the names of ROS 1 for the fields of a time as well."""

    time: Time

    @field_validator("time", mode="before")
    @classmethod
    def _of_ros_2(cls, value: dict[str, int]) -> dict[str, int]:
        return {"sec": value["sec"], "nanosec": value["nanosec"]}
