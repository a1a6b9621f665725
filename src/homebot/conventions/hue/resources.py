"""The resources of a Hue bridge, as it listed and changed them. Pure.

Source: Philips Hue, CLIP API v2: ``GET /clip/v2/resource``, and the events ``add``, ``update`` and ``delete``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from homebot.conventions.hue.resource_row import Fields, at
from homebot.conventions.payload import as_fields, shown
from homebot.errors import WireError

__all__ = ["HueResources"]

MAX_RESOURCES: Final = 20_000
_LONGEST_ID: Final = 100
_DESCRIBING: Final = frozenset({"metadata", "services", "children", "product_data", "group"})
"""Fields that parts, names and rooms depend on; values do not."""


class HueResources:
    """The resources of one bridge, by their ids."""

    def __init__(self) -> None:
        self._by_id: dict[str, Fields] = {}

    def get(self, rid: str) -> Fields:
        """Return a resource; an empty one if there is none."""
        return self._by_id.get(rid, {})

    def replace(self, listed: object) -> None:
        """Keep the resources that the bridge *listed*, and no others; raise WireError if it is no list of them."""
        if not isinstance(listed, list) or len(listed) > MAX_RESOURCES:
            raise WireError(f"the resources of the bridge are {shown(listed)}, not a list of at most {MAX_RESOURCES}")
        self._by_id = {_id_of(one): as_fields(one) for one in listed}

    def change(self, kind: str, item: object) -> bool:
        """Apply a change: ``add``, ``update`` or ``delete``; return whether other devices or parts may come of it.

        Raises:
            WireError: It has no id, there is no such resource, or there are too many.
        """
        rid, fields = _id_of(item), as_fields(item)
        before = self._by_id.get(rid)
        match kind:
            case "add" if before is not None or len(self._by_id) < MAX_RESOURCES:
                self._by_id[rid] = fields
            case "delete":
                self._by_id.pop(rid, None)
            case "update" if before is not None:
                self._by_id[rid] = _merged(before, fields)
                return bool(fields.keys() & _DESCRIBING) or before.get("type") == "zigbee_connectivity"
            case "add" | "update":
                raise WireError(f"the resource {rid} is unknown, or more than {MAX_RESOURCES}")
            case _:
                return False
        return True

    def of_type(self, *types: str) -> Iterator[tuple[str, Fields]]:
        """Yield the resources of these types, with their ids."""
        return ((rid, one) for rid, one in self._by_id.items() if one.get("type") in types)

    def referred(self, resource: Fields, name: str) -> Iterator[tuple[str, Fields]]:
        """Yield the ``services`` or ``children`` of a resource, in its own order, with their ids."""
        listed = resource.get(name)
        for rid in (at(one, "rid") for one in (listed if isinstance(listed, list) else ())):
            if isinstance(rid, str) and rid in self._by_id:
                yield rid, self._by_id[rid]


def _id_of(resource: object) -> str:
    rid = at(resource, "id")
    if not isinstance(rid, str) or not 0 < len(rid) <= _LONGEST_ID or not rid.isprintable():
        raise WireError(f"a resource has the id {shown(rid)}")
    return rid


def _merged(before: Fields, change: Fields) -> Fields:
    merged = dict(before)
    for name, value in change.items():
        old = merged.get(name)
        merged[name] = _merged(old, value) if isinstance(old, Mapping) and isinstance(value, Mapping) else value
    return merged
