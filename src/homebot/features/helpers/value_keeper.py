"""The keeper of the values of helpers across restarts."""

from __future__ import annotations

from collections.abc import MutableMapping
from typing import TYPE_CHECKING, Any, Final, final

from homebot.devices.device import KeyValue
from homebot.features.helpers.messages import (
    KeepHelperValues,
    KeepHelperValuesRequest,
    KeepHelperValuesResponse,
)
from homebot.graph import Node

if TYPE_CHECKING:
    from homebot.feature_context import FeatureContext

_STORE: Final = "helper values"
_MAX_KEPT: Final = 200


@final
class ValueKeeper:
    """Keeps the latest value of each helper; beyond 200 the oldest are dropped."""

    def __init__(self, node: Node, store: MutableMapping[str, Any]) -> None:
        self._node = node
        self._store = store

    def serve(self, name: str) -> None:
        """Create the service."""
        self._node.create_service(KeepHelperValues, name, self._save_values)

    def _save_values(self, request: KeepHelperValuesRequest) -> KeepHelperValuesResponse:
        for value in request.values:
            self._store[value.key] = value.value
        for key in [*self._store][:-_MAX_KEPT]:
            del self._store[key]
        values = tuple(KeyValue(key=key, value=value) for key, value in self._store.items())
        return KeepHelperValuesResponse(success=True, message="", values=values)


def start(node: Node, house: FeatureContext) -> ValueKeeper:
    """Return the server of the feature."""
    return ValueKeeper(node, house.store(_STORE))
