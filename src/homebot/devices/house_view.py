"""One node's view of the house: the newest description and values of its devices."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing, suppress
from functools import cached_property, partial
from typing import TYPE_CHECKING, Final, final
from weakref import WeakKeyDictionary, WeakValueDictionary, ref

import anyio

from homebot.devices.device import ChangeKind, Device, DeviceChange, StateChange
from homebot.devices.device_view import DeviceView
from homebot.devices.name_checks import NameChecks
from homebot.devices.names import DEVICE_CHANGES, DEVICE_STATES, DIRECTORY_NODE, FIND_DEVICES, GET_CAUSES, QUERY_DEVICES
from homebot.devices.query.term_messages import query_terms
from homebot.devices.query.terms import Query
from homebot.devices.services import (
    FindDevices,
    FindDevicesRequest,
    FindDevicesResponse,
    QueryDevices,
    QueryDevicesRequest,
    QueryDevicesResponse,
)
from homebot.errors import ClosedError, RefusedError, ServiceError
from homebot.graph import Client, Node
from homebot.log import LogLimit

if TYPE_CHECKING:
    from homebot.devices.commander import Commander
    from homebot.devices.journal_messages import KnownCause

NO_ANSWER = "devices.no_answer"

_GATHERED: Final = 0.6
"""Seconds for which the directory gathers changes of settings, and a little more."""

_PAUSE: Final = 0.5
"""Seconds until a directory that did not answer is asked again."""


class HouseWatcher:
    """Receiver of the changes of the house, such as a live query; its methods do nothing, and must not block."""

    def on_device(self, change: DeviceChange) -> None:
        """Handle a device that appeared, changed or was removed."""

    def on_values(self, change: StateChange) -> None:
        """Handle new values of a known device."""

    def on_event(self, change: StateChange) -> None:
        """Handle an event, perhaps of a device that is not described yet."""

    def close(self) -> None:
        """End with the node."""


@final
class HouseView:
    """The newest description and values of the devices that one node uses; :meth:`of` returns the node's view.

    A device is stored as long as a handle refers to it, and every device of the house while there are watchers. After a
    restart of the directory the watchers receive the differences.

    Args:
        node: The node; the view is up to date until it ends.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._limit = LogLimit(node.graph.clock)
        self._views: WeakValueDictionary[str, DeviceView] = WeakValueDictionary()
        self._house: dict[str, DeviceView] = {}
        self._watchers: dict[HouseWatcher, None] = {}
        self._watch: anyio.CancelScope | None = None
        self._is_complete = anyio.Event()
        self._compared = 0  # number of the last change included in the last comparison
        self._changed: dict[str, int] = {}  # number of each device's last change since the request
        node.create_subscription(DeviceChange, DEVICE_CHANGES, self._on_change, 1, from_node=DIRECTORY_NODE)
        node.create_subscription(StateChange, DEVICE_STATES, self._on_state, 1, from_node=DIRECTORY_NODE)

    @classmethod
    def of(cls, node: Node) -> HouseView:
        """Return the view of *node*, shared by all its handles and live queries."""
        known = _VIEWS.get(node)
        view = None if known is None else known()
        if view is None:
            view = cls(node)
            _VIEWS[node] = ref(view)
        return view

    @cached_property
    def commander(self) -> Commander:
        """The commander of the node, which gives the commands of handles."""
        from homebot.devices.commander import Commander  # noqa: PLC0415 - many apps only watch

        return Commander(self._node)

    async def find(self, query: Query) -> FindDevicesResponse:
        """Return the devices that match *query*, sorted by id.

        Raises:
            ServiceError: The directory does not answer.
        """
        return await self._find.call(FindDevicesRequest(query=query_terms(query)))

    async def find_near(self, query: Query) -> FindDevicesResponse:
        """Return the devices that match *query*, which has a condition to be near a robot, best first.

        There are none if a name in it is misspelt, such as that of the robot; :attr:`names` reports it.

        Raises:
            RefusedError: The position of the robot is unknown now.
            ServiceError: The directory does not answer.
        """
        answer = await self._query.call(QueryDevicesRequest(query=query_terms(query)))
        if not answer.success and not answer.is_mistake:
            raise RefusedError("the search", answer.message)
        return FindDevicesResponse(devices=tuple(result.device for result in answer.results), sequence=answer.sequence)

    async def cause(self, device: str, part: str, capability: str) -> KnownCause | None:
        """Return the cause of the newest change of a value; None if the control layer does not know it."""
        from homebot.devices.journal_messages import GetCauses, GetCausesRequest  # noqa: PLC0415 - few apps ask for it

        with closing(self._node.create_client(GetCauses, GET_CAUSES)) as client, suppress(ServiceError):
            for pause in (0.0, _GATHERED):  # the first change of a part comes to the control layer with some others
                await anyio.sleep(pause)
                for cause in (await client.call(GetCausesRequest(devices=(device,)))).causes:
                    if (cause.part, cause.capability) == (part, capability):
                        return cause
        return None

    @cached_property
    def names(self) -> NameChecks:
        """The checks of the names in the queries of the node."""
        return NameChecks(self._node)

    @cached_property
    def _query(self) -> Client[QueryDevicesRequest, QueryDevicesResponse]:
        return self._node.create_client(QueryDevices, QUERY_DEVICES)

    def get(self, device_id: str) -> DeviceView | None:
        """Return a device of the watched house; None if there is no such device."""
        return self._house.get(device_id)

    @property
    def devices(self) -> Iterator[Device]:
        """The devices of the watched house, with their values."""
        return (view.current() for view in self._house.values())

    def store(self, device: Device, sequence: int) -> DeviceView:
        """Return the shared view of *device*, updated with this description."""
        view = self._views.get(device.id)
        if view is None:
            view = self._views[device.id] = DeviceView(device, sequence)
        else:
            view.update(device, sequence)
        return view

    async def wait_until_complete(self) -> None:
        """Wait until the watchers have received all devices in the directory."""
        await self._is_complete.wait()

    def add(self, watcher: HouseWatcher) -> None:
        """Report the whole house to *watcher*, and then every change, until it is removed or the node ends."""
        self._watchers[watcher] = None
        for view in self._house.values():
            watcher.on_device(_change("appeared", view.current(), view.sequence, "it was already known"))
        if self._watch is None:
            self._watch = anyio.CancelScope()
            self._node.create_task(partial(self._follow_directory, self._watch))

    def remove(self, watcher: HouseWatcher) -> None:
        """Stop reporting to *watcher*; idempotent."""
        self._watchers.pop(watcher, None)
        if not self._watchers and self._watch is not None:
            self._watch.cancel()
            self._watch = None
            self._house.clear()
            self._is_complete = anyio.Event()
            self._changed.clear()

    async def _follow_directory(self, scope: anyio.CancelScope) -> None:
        """Compare the house with the directory now and after each restart of the directory."""
        try:
            with scope, suppress(ClosedError):
                async for _ in self._node.graph.watch_services(FIND_DEVICES):
                    self._compare(await self._ask())
        finally:
            if self._watch is scope:
                for watcher in tuple(self._watchers):
                    watcher.close()

    async def _ask(self) -> FindDevicesResponse:
        while True:
            await self._find.wait_for_service()
            try:
                self._changed.clear()
                return await self._find.call(FindDevicesRequest())
            except ServiceError as exc:
                if self._limit.allows(NO_ANSWER) is not None:
                    self._node.log.warning(NO_ANSWER, message=f"{exc}; trying again")
                await anyio.sleep(_PAUSE)

    def _compare(self, response: FindDevicesResponse) -> None:
        """Report the differences between the house and a snapshot; changes up to its number are outdated then."""
        newer = {device for device, sequence in self._changed.items() if sequence > response.sequence}
        for device_id in self._house.keys() - {device.id for device in response.devices} - newer:
            why = "it was removed while the directory was not running"
            self._report(_change("removed", self._house[device_id].device, response.sequence, why))
        for device in response.devices:
            before = self._house.get(device.id)
            if device.id in newer:
                continue
            if before is None:
                self._report(_change("appeared", device, response.sequence, "it was already known"))
            elif _differs(before, device):
                why = "it changed while the directory was not running"
                self._report(_change("changed", device, response.sequence, why))
        self._compared = response.sequence
        self._changed.clear()
        self._is_complete.set()

    def _on_change(self, change: DeviceChange) -> None:
        if change.sequence <= self._compared:
            return
        device = change.device
        known = self._house.get(device.id)
        if change.kind == "appeared" and known is not None and not _differs(known, device):
            known.update(device, change.sequence)  # a restarted directory that reads the announcements again
        elif self._watchers:
            self._report(change)
        elif (view := self._views.get(device.id)) is not None:
            view.update(device, change.sequence, is_gone=change.kind == "removed")

    def _report(self, change: DeviceChange) -> None:
        device = change.device
        view = self.store(device, change.sequence)
        if change.kind == "removed":
            view.update(device, change.sequence, is_gone=True)
            self._house.pop(device.id, None)
        else:
            self._house[device.id] = view
        self._changed[device.id] = change.sequence
        for watcher in tuple(self._watchers):
            watcher.on_device(change)

    def _on_state(self, change: StateChange) -> None:
        if change.is_event:
            for watcher in tuple(self._watchers):
                watcher.on_event(change)
        elif (view := self._views.get(change.device)) is not None:
            view.record_values(change)
            for watcher in tuple(self._watchers):
                watcher.on_values(change)


_VIEWS: Final[WeakKeyDictionary[Node, ref[HouseView]]] = WeakKeyDictionary()


def _change(kind: ChangeKind, device: Device, sequence: int, why: str) -> DeviceChange:
    return DeviceChange(kind=kind, device=device, sequence=sequence, why=why)


def _differs(view: DeviceView, device: Device) -> bool:
    return _description(view.device) != _description(device) or any(
        view.value(state.part, state.capability) != state.value.plain() for state in device.states
    )


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
