"""Requests of the command line to the directory."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, TypeVar, cast

from homebot.cli.door_client import DoorClient
from homebot.cli.graph_queries import entities
from homebot.cli.remarks import remark
from homebot.cli.terminal import progress
from homebot.devices.device_names import ask_which, devices_called, names_of
from homebot.devices.names import EXPLAIN_DEVICE, FIND_DEVICES, GET_UNAPPROVED, QUERY_DEVICES
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import to_seconds
from homebot.errors import PeerError, UsageError
from homebot.support.names import CLOSE, did_you_mean, similar_to, spellings
from homebot.support.printable import printable
from homebot.words.tokens import quoted

if TYPE_CHECKING:
    from homebot.devices import Device
    from homebot.devices.approval_messages import UnapprovedResponse
    from homebot.devices.journal_messages import ExplainDeviceResponse
    from homebot.devices.services import QueryDevicesResponse
    from homebot.messages import Time

T = TypeVar("T")

_WIDEST = 1000

_PAGE = 200
"""Devices in one answer, which takes a few milliseconds to assemble."""

_ROUNDS = 3
"""Attempts to read all pages, in case devices move between pages so that one is missed."""


def all_devices(door: DoorClient, convert: Callable[[Device], T], service_type: str = "") -> list[T]:
    """Return the result of *convert* for each device that offers *service_type* (empty: all), sorted by id."""
    converted: dict[str, T] = {}
    if service_type:
        answer = JsonMessage(door.call(FIND_DEVICES, {"service_type": service_type, "is_checked": False}))
        converted = {device.id: convert(device) for device in cast("list[Device]", answer.devices)}
    for _ in range(0 if service_type else _ROUNDS):
        page = find_devices(door, "", _PAGE)
        total, offset = page.total, 0
        with progress("devices", total if total > _PAGE else 0) as show:
            while page.results:
                offset += _PAGE
                following = _begin_query(door, "", _PAGE, offset) if offset < total else None
                for result in page.results:
                    converted[result.device.id] = convert(result.device)
                show(len(converted))
                if following is None:
                    break
                page = following()
                total = page.total
        if len(converted) >= total:
            break
    return [converted[device_id] for device_id in sorted(converted)]


def find_devices(door: DoorClient, query: str, limit: int = 0, *, is_spelled: bool = False) -> QueryDevicesResponse:
    """Return the matches of *query*, best first, up to *limit*.

    Args:
        is_spelled: Whether a typo or a beginning matches nothing.

    Raises:
        PeerError: The query is not understood; the message names the part that is not.
    """
    return _begin_query(door, query, limit, 0, is_spelled=is_spelled)()


def matching_devices(door: DoorClient, query: str) -> list[Device]:
    """Return all devices that match *query*; all of the house if it is empty.

    Raises:
        PeerError: The query is not understood; the message names the part that is not.
    """
    devices: list[Device] = []
    total = 1
    while len(devices) < total:
        page = _begin_query(door, query, _PAGE, len(devices))()
        devices += [result.device for result in page.results]
        total = page.total if page.results else 0
    return devices


def named_device(door: DoorClient, name: str) -> Device:
    """Return the only device with the id or name *name*, ignoring case and accents of a name.

    Raises:
        UsageError: *name* is empty.
        PeerError: There is none (names similar ones), or there are several (names all).
    """
    device_or_names = _find_named(door, name)
    if isinstance(device_or_names, list):
        raise PeerError(
            f"there is no device {name}; {did_you_mean(name, device_or_names, '`homebot devices` lists all')}"
        )
    return device_or_names


def device_or_similar(door: DoorClient, name: str) -> Device | list[str]:
    """Return the only device with the id or name *name*; if there is none, the ids and names that are a typo away.

    Raises:
        UsageError: *name* is empty.
        PeerError: There are several; names all.
    """
    device_or_names = _find_named(door, name)
    return similar_to(name, device_or_names, CLOSE) if isinstance(device_or_names, list) else device_or_names


def _find_named(door: DoorClient, name: str) -> Device | list[str]:
    """Return the only device that is called *name*; if there is none, the ids and names of all."""
    if not name.strip():
        raise UsageError("give the id or the name of a device; `homebot devices` lists all")
    query = " or ".join(f"{field}={quoted(spelling)}" for spelling in spellings(name) for field in ("id", "name"))
    answer = JsonMessage(door.call(FIND_DEVICES, {"query": query, "is_checked": False}))
    called = devices_called(name, cast("list[Device]", answer.devices))
    persons = [device for device in called if "x_person" in device.service_types]
    if len(called) > 1 and len(persons) != 1:
        raise PeerError(printable(ask_which(name, called), _WIDEST))
    if called:
        return (persons or called)[0]
    return [printable(text) for names in all_devices(door, names_of) for text in names]


def reasons_for(door: DoorClient, device: Device) -> Sequence[str]:
    """Return why a search for the device's name finds it, and the reasons for its rank."""
    devices = find_devices(door, quoted(device.name))
    return next((result.reasons for result in devices.results if result.device.id == device.id), ())


def print_note(response: QueryDevicesResponse, *, as_json: bool) -> None:
    """Print the note on the devices *response*, such as that they have only words similar to one of the query."""
    if response.message:
        remark(printable(response.message, _WIDEST), as_json=as_json)


def why_none(response: QueryDevicesResponse, query: str) -> str:
    """Return why *query* finds nothing."""
    reason = "" if response.pose_age or response.left_out else response.message
    return printable(reason or f"no device matches {query!r}; `homebot devices` lists all", _WIDEST)


def unapproved(door: DoorClient, device: str = "") -> frozenset[str]:
    """Return the ids of the devices that wait for approval; if *device* is given, only that."""
    return frozenset(_unapproved(door, device).devices)


def limits_of(door: DoorClient, device: Device) -> Iterator[tuple[str, str]]:
    """Yield rows about why *device* always asks or is not harmless, what changes that, and its pending approval."""
    answer = _unapproved(door, device.id)
    for reason in answer.reasons:
        yield "always asks", f"{reason.value}; a right must name it, such as 'act: id=\"{device.id}\"'"
    if answer.limits:
        whys = [f"{limit.key}: {limit.value}" if len(device.parts) > 1 else limit.value for limit in answer.limits]
        change = f"if it can hurt nobody, homebot tag add {shlex.quote(device.name)} harmless"
        yield "not harmless", "; ".join((*whys, change))
    if answer.devices:
        yield "approval", "missing: it is dangerous, and gets no commands before `homebot approve DEVICE`"


def ineffective_routes(door: DoorClient, device: Device) -> frozenset[tuple[str, str]]:
    """Return the part and gateway/key of each route that is tried last, because its last commands had no effect."""
    has_choice = any(len(part.routes) > 1 for part in device.parts)
    if not (has_choice and entities(door, kind="service", name=EXPLAIN_DEVICE)):
        return frozenset()
    response = cast("ExplainDeviceResponse", JsonMessage(door.call(EXPLAIN_DEVICE, {"device": device.id})))
    return frozenset((item.key, item.value) for item in response.ineffective)


def _unapproved(door: DoorClient, device: str) -> UnapprovedResponse:
    is_served = entities(door, kind="service", name=GET_UNAPPROVED)  # it is missing without a control layer
    nothing: dict[str, object] = {"devices": [], "reasons": [], "limits": []}
    fields = door.call(GET_UNAPPROVED, {"device": device}) if is_served else nothing
    return cast("UnapprovedResponse", JsonMessage(fields))


def house_time(door: DoorClient) -> float:
    """Return homebot's current time, in seconds since 1970."""
    return to_seconds(cast("Time", JsonMessage(door.call("/rosapi/get_time")).time))


def _begin_query(
    door: DoorClient, query: str, limit: int, offset: int, *, is_spelled: bool = False
) -> Callable[[], QueryDevicesResponse]:
    asked = {"query": query, "offset": offset, "limit": limit, "is_spelled": is_spelled}
    response = door.begin_call(QUERY_DEVICES, asked)

    def page() -> QueryDevicesResponse:
        answer = cast("QueryDevicesResponse", JsonMessage(response()))
        if not answer.success:
            raise PeerError(answer.message)
        return answer

    return page
