"""The resources of a Hue bridge, as it listed and changed them, and the rows of their capabilities. Pure.

Source: Philips Hue, CLIP API v2: ``GET /clip/v2/resource``, and the events ``add``, ``update`` and ``delete``.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Final, TypeAlias

from homebot.conventions.capability_row import CapabilityRow
from homebot.conventions.payload import as_fields, shown
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.errors import WireError

Fields: TypeAlias = Mapping[str, object]
"""A resource, or an object in one, as the bridge sends it."""

HueBody: TypeAlias = dict[str, object]
"""The changes that a request asks for."""


HueRow: TypeAlias = CapabilityRow[Fields, Callable[[Fields], PlainValue], Callable[[Fields, Command], HueBody]]
"""A capability of a resource; it is watched by the fields of which a report has one."""


def hue_row(
    kind: str,
    capability: str,
    fields: tuple[str, ...],
    read: Callable[[Fields], PlainValue] | None = None,
    write: Callable[[Fields, Command], HueBody] | None = None,
    needs: str = "id",
    bounds: Callable[[Fields], tuple[float, ...]] | tuple[()] = (),
    options: Callable[[Fields], tuple[str, ...]] | tuple[()] = (),
) -> HueRow:
    """Return the row of a capability of the resources of a *kind*, such as ``light``, with the field that it *needs*.

    Args:
        fields: The fields that its value depends on; a resource with one of them reports it.
    """
    return HueRow(
        capability,
        read,
        write,
        lambda resource: resource.get("type") == kind and needs in resource,
        options,
        bounds,
        readable=lambda resource: any(field in resource for field in fields),
        watched=fields,
    )


def at(resource: object, *path: str) -> object:
    """Return the value at a path of names in JSON objects; None if there is none."""
    for name in path:
        resource = resource.get(name) if isinstance(resource, Mapping) else None
    return resource


MAX_RESOURCES: Final = 20_000
_MAX_ID_CHARACTERS: Final = 100
_DESCRIBING: Final = frozenset({"metadata", "name", "services", "children", "product_data", "group", "actions"})
"""Fields that parts, names and rooms depend on; values do not."""


class HueResources:
    """The resources of one bridge, by their ``ids``."""

    def __init__(self) -> None:
        self._by_id: dict[str, Fields] = {}
        self._holders: dict[str, dict[str, None]] = {}
        self.ids = self._by_id.keys()

    def get(self, rid: str) -> Fields:
        """Return a resource; an empty one if there is none."""
        return self._by_id.get(rid, {})

    def replace(self, listed: object) -> None:
        """Keep the resources that the bridge *listed*, and no others; raise WireError if it is no list of them."""
        if not isinstance(listed, list) or len(listed) > MAX_RESOURCES:
            raise WireError(f"the resources of the bridge are {shown(listed)}, not a list of at most {MAX_RESOURCES}")
        resources = {_id_of(resource): as_fields(resource) for resource in listed}
        self._by_id.clear()
        self._holders.clear()
        for rid, resource in resources.items():
            self._set(rid, resource)

    def change(self, kind: str, item: object) -> frozenset[str]:
        """Apply a change: ``add``, ``update`` or ``delete``.

        Returns:
            The ids of the devices, and of the rooms and zones with their scenes, that may be others now; there may be
            ids of other resources among them.

        Raises:
            WireError: It has no id, there is no such resource, or there are too many.
        """
        rid, fields = _id_of(item), as_fields(item)
        before = self.get(rid)
        match kind:
            case "add" if before or len(self._by_id) < MAX_RESOURCES:
                return self._set(rid, fields)
            case "delete":
                return self._set(rid, {})
            case "update" if before:
                after = merged(before, fields)
                if fields.keys() & _DESCRIBING or before.get("type") == "zigbee_connectivity":
                    return self._set(rid, after)
                self._by_id[rid] = after
            case "add" | "update":
                raise WireError(f"the resource {rid} is unknown, or more than {MAX_RESOURCES}")
        return frozenset()

    def referred(self, resource: Fields, name: str) -> Iterator[tuple[str, Fields]]:
        """Yield the ``services`` or ``children`` of a resource, in its own order, with their ids."""
        return ((rid, self._by_id[rid]) for rid in _references(resource, name) if rid in self._by_id)

    def holders(self, rid: str, *types: str) -> Iterator[tuple[str, Fields]]:
        """Yield the resources of these types that a resource belongs to, or the scenes of a group, with their ids."""
        holders = ((holder, self._by_id[holder]) for holder in self._holders.get(rid, ()))
        return ((holder, resource) for holder, resource in holders if resource.get("type") in types)

    def _set(self, rid: str, after: Fields) -> frozenset[str]:
        before = self._by_id.pop(rid, {})
        if after:
            self._by_id[rid] = after
        was, now = _held(before), _held(after)
        for target in was - now:
            del self._holders[target][rid]
            if not self._holders[target]:
                del self._holders[target]
        for target in now - was:
            self._holders.setdefault(target, {})[rid] = None
        is_the_same = all(before.get(field) == after.get(field) for field in ("type", "metadata", "actions"))
        changed = {rid, *(was ^ now if is_the_same else was | now)}
        touched = changed.union(*(self._holders.get(resource, ()) for resource in changed))
        return frozenset(
            touched.union(home for resource in touched for home, _ in self.holders(resource, "bridge_home"))
        )


def _held(resource: Fields) -> frozenset[str]:
    """Return the ids of the services of a device, of what is in a room or zone, or of the room or zone of a scene."""
    group = at(resource, "group", "rid")
    listed = (rid for name in ("services", "children") for rid in _references(resource, name))
    return frozenset((*listed, *((group,) if isinstance(group, str) else ())))


def _references(resource: Fields, name: str) -> Iterator[str]:
    listed = resource.get(name)
    ids = (at(entry, "rid") for entry in (listed if isinstance(listed, list) else ()))
    return (rid for rid in ids if isinstance(rid, str))


def _id_of(resource: object) -> str:
    rid = at(resource, "id")
    if not isinstance(rid, str) or not 0 < len(rid) <= _MAX_ID_CHARACTERS or not rid.isprintable():
        raise WireError(f"a resource has the id {shown(rid)}")
    return rid


def merged(before: Fields, change: Fields) -> Fields:
    """Return a resource, or an object in one, after a change of some of its fields."""
    after = dict(before)
    for name, value in change.items():
        old = after.get(name)
        after[name] = merged(old, value) if isinstance(old, Mapping) and isinstance(value, Mapping) else value
    return after
