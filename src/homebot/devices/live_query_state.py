"""State of a live query: the devices that its reader has, and the changes to come. Pure."""

from __future__ import annotations

from collections.abc import Iterator
from typing import final

from homebot.devices.device import ChangeKind, Device, DeviceChange, StateChange
from homebot.devices.query import And, Not, Or, Query, StateIs, facets_of, fits

__all__ = ["LiveQueryState"]

NO_LONGER = "it no longer matches the query"


@final
class LiveQueryState:
    """Filter of the directory's changes for one reader, which may miss some of them or meet a new directory.

    To the reader, each device appears first, is removed last, and may then appear again; between the two come the other
    changes. A device that no longer matches is removed, and one that comes to match appears.

    Args:
        query: The query that the devices match.

    Attributes:
        wants_states: Whether the query has conditions on values, so that changes of states matter.
    """

    def __init__(self, query: Query) -> None:
        self._query = query
        self.wants_states = _has_states(self._query)
        self._known: dict[str, Device] = {}
        self._house: dict[str, tuple[Device, int]] = {}
        self._sequence = 0

    def take(self, change: DeviceChange) -> DeviceChange | None:
        """Return the change for the reader, or None if *change* does not concern it."""
        if change.sequence <= self._sequence:
            return None
        device = change.device
        known = self._known.get(device.id)
        is_gone = change.kind == "removed"
        if self.wants_states:
            self._remember(device, change.sequence, is_gone=is_gone)
        if is_gone or not self._wants(device):
            if known is None:
                return None
            del self._known[device.id]
            return change if is_gone else change.model_copy(update={"kind": "removed"})
        self._known[device.id] = device
        if known is None:
            return change if change.kind == "appeared" else change.model_copy(update={"kind": "appeared"})
        return change.model_copy(update={"kind": "changed"}) if change.kind == "appeared" else change

    def take_state(self, change: StateChange) -> DeviceChange | None:
        """Return the change for the reader of new values: that the device matches now, or no longer.

        An event makes no device match.
        """
        if change.is_event:
            return None
        device, sequence = self._house.get(change.device, (None, 0))
        if device is None or change.sequence <= max(sequence, self._sequence):
            return None
        new = {(one.part, one.capability) for one in change.states}
        others = [one for one in device.states if (one.part, one.capability) not in new]
        device = device.model_copy(update={"states": (*others, *change.states)})
        self._house[device.id] = device, change.sequence
        fitted, does_fit = device.id in self._known, self._wants(device)
        if does_fit:
            self._known[device.id] = device
        else:
            self._known.pop(device.id, None)
        if fitted == does_fit:
            return None
        told = ", ".join(f"its {one.capability} is {one.value.plain()}" for one in change.states)
        why = f"{told} now" if does_fit else NO_LONGER
        kind: ChangeKind = "appeared" if does_fit else "removed"
        return DeviceChange(kind=kind, device=device, sequence=change.sequence, why=why)

    def compare(self, devices: tuple[Device, ...], sequence: int) -> Iterator[DeviceChange]:
        """Yield the differences of a snapshot to the reader's devices; changes up to *sequence* are old from now on."""
        self._sequence = sequence
        if self.wants_states:
            self._house = {device.id: (device, sequence) for device in devices}
        wanted = {device.id: device for device in devices if self._wants(device)}
        known, self._known = self._known, wanted
        for device_id, device in known.items():
            if device_id not in wanted:
                yield DeviceChange(
                    kind="removed",
                    device=device,
                    sequence=sequence,
                    why="it was removed while the directory was not running",
                )
        for device_id, device in wanted.items():
            before = known.get(device_id)
            if before is None:
                yield DeviceChange(kind="appeared", device=device, sequence=sequence, why="it was already known")
            elif _description(before) != _description(device):
                yield DeviceChange(
                    kind="changed",
                    device=device,
                    sequence=sequence,
                    why="it changed while the directory was not running",
                )

    def _wants(self, device: Device) -> bool:
        return self._query == _ANY or fits(self._query, facets_of(device))

    def _remember(self, device: Device, sequence: int, *, is_gone: bool) -> None:
        if is_gone:
            self._house.pop(device.id, None)
        else:
            self._house[device.id] = device, sequence


_ANY = And(())


def _has_states(query: Query) -> bool:
    match query:
        case And(terms) | Or(terms):
            return any(_has_states(term) for term in terms)
        case Not(term):
            return _has_states(term)
        case _:
            return isinstance(query, StateIs)


def _description(device: Device) -> tuple[object, ...]:
    return (
        device.name,
        device.service_type,
        device.service_types,
        device.area,
        device.endpoints,
        device.metadata,
        device.parts,
        device.freshness,
        device.reachable.state,
        device.offline_parts,
        device.conflicts,
    )
