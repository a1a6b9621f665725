"""Devices in short form, as screens and agents list them: without the values of settings and diagnostics. Pure."""

from collections.abc import Iterable, Iterator
from typing import Final, final

from homebot.devices.always_ask import waits_for_approval, why_it_asks
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.client_rights import ALL_RIGHTS, ClientRights
from homebot.devices.device import Device, DevicePart, State
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.harmless import why_not_covered
from homebot.devices.services import ListDevicesRequest, ListedDevice, ListedReading
from homebot.discovery.description import position_of
from homebot.messages.builtin_interfaces import Time
from homebot.messages.key_value import KeyValue
from homebot.rights import Right
from homebot.words.opening_kinds import opening_kind

_UNKNOWN: Final = Time(sec=0, nanosec=0)
_MAX_KEPT: Final = 2000


def rights_in(request: ListDevicesRequest) -> ClientRights:
    """Return the rights to devices of the client that asks; homebot's own nodes have all."""
    if not request.issuer:
        return ALL_RIGHTS
    from homebot.words.rights import rights_of  # noqa: PLC0415 - for clients alone

    return rights_of(request.scope) if Right.ACT.value in request.rights else ClientRights()


@final
class ShortForms:
    """Devices in short form as they were listed last, which are kept while a device and the rights are the same.

    Of more than 2,000 the oldest is made again when it is listed.

    Attributes:
        made: How many were made, not taken from the last listing.
    """

    def __init__(self) -> None:
        self._last: dict[str, tuple[Device, ClientRights, bool, ListedDevice]] = {}
        self.made = 0

    def of(self, device: Device, rights: ClientRights, *, needs_approval: bool) -> ListedDevice:
        """Return :func:`list_device` of these."""
        last = self._last.get(device.id)
        if last is not None and last[0] is device and last[1:3] == (rights, needs_approval):
            return last[3]
        self.made += 1
        short = list_device(device, rights, needs_approval=needs_approval)
        self._last[device.id] = device, rights, needs_approval, short
        if len(self._last) > _MAX_KEPT:
            del self._last[next(iter(self._last))]
        return short


def list_device(device: Device, rights: ClientRights, *, needs_approval: bool) -> ListedDevice:
    """Return *device* in short form.

    Args:
        rights: The rights of the client that asks.
        needs_approval: Whether commands wait for the owner's approval.
    """
    position = position_of(device.facts)
    used = {part.id: part for part in device.parts if not part.part.category}
    settable = {
        part.id: [capability.name for capability in part.part.capabilities if capability.settable]
        for part in used.values()
    }
    asks = {part: why_it_asks(device, used[part]) for part, names in settable.items() if names}
    return ListedDevice(
        id=device.id,
        name=device.name,
        type=device.service_type
        if device.service_type in DEVICE_TYPES
        else (*device.service_types, device.service_type)[0],
        room=device.area,
        freshness=device.freshness,
        is_reachable=device.reachable.state != "no",
        waits=needs_approval and waits_for_approval(device),
        states=tuple(_list_state(state) for state in device.states if state.part in used),
        position=() if position is None else (position.x, position.y),
        settable=tuple(dict.fromkeys(name for names in settable.values() for name in names)),
        tags=device.tags,
        asks_first=tuple(dict.fromkeys(name for part, why in asks.items() if why for name in settable[part])),
        codes=_list_codes(used.values()),
        kind=opening_kind(device),
        may_act=any(_may_act(rights, device, used[part], why) for part, why in asks.items()),
        units=tuple(_own_units(used.values())),
    )


def _list_state(state: State) -> ListedReading:
    since = _UNKNOWN if state.is_first else state.since
    return ListedReading(part=state.part, capability=state.capability, value=state.value, since=since)


def _own_units(parts: Iterable[DevicePart]) -> Iterator[KeyValue]:
    """Yield the unit of each capability of *parts* that has none in the vocabulary."""
    for part in parts:
        for capability in part.part.capabilities:
            if capability.unit and not CAPABILITIES[capability.name].unit:
                yield KeyValue(key=f"{part.id} {capability.name}", value=capability.unit)


def _list_codes(parts: Iterable[DevicePart]) -> tuple[KeyValue, ...]:
    """Return the code of each capability of *parts* that has one."""
    capabilities = [capability for part in parts for capability in part.part.capabilities]
    codes = {capability.name: capability.code for capability in capabilities if capability.code}
    return tuple([KeyValue(key=name, value=code) for name, code in codes.items()])


def _may_act(rights: ClientRights, device: Device, part: DevicePart, why_asks: str) -> bool:
    """Return whether *rights* allow some command to *part*; to a group, as far as its members allow it."""
    is_group = rights.acts_on_harmless and bool(part.part.members)
    return is_group or why_not_covered(rights, device, part, why_asks) is None
