"""The list of the groups of a house, of the owner and of gateways, with their members."""

from collections.abc import Awaitable, Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from homebot.devices import Device, DevicePart, KeyValue
from homebot.devices.device import is_commanded, part_names, target_of
from homebot.devices.device_lookup import references
from homebot.devices.group_messages import GroupInfo, ListGroups, ListGroupsRequest, ListGroupsResponse
from homebot.devices.names import LIST_GROUPS
from homebot.devices.query.matching import groups_of
from homebot.discovery.groups import group_name
from homebot.discovery.index import DeviceIndex
from homebot.graph import Node
from homebot.support.folding import fold
from homebot.support.names import find_name, no_such


class GroupList:
    """The service that lists the groups of *index*.

    Args:
        catch_up: Returns when the index has all that was announced.
    """

    def __init__(self, index: DeviceIndex, catch_up: Callable[[], Awaitable[None]]) -> None:
        self._index = index
        self._catch_up = catch_up

    def serve(self, node: Node) -> None:
        """Create the service on *node*."""
        node.create_service(ListGroups, LIST_GROUPS, self._list)

    async def _list(self, request: ListGroupsRequest) -> ListGroupsResponse:
        await self._catch_up()
        owner = self._index.owner
        groups = list_groups(self._index.devices(), {} if owner.groups is None else owner.groups.queries)
        if not request.name.strip():
            return ListGroupsResponse(success=True, groups=groups)
        names = [group.name for group in groups]
        wanted = fold(find_name(request.name, names) or request.name)
        groups = tuple([group for group in groups if wanted == fold(group.name) or request.name == group.id])
        problem = "" if groups else no_such("group", request.name, names, "`homebot group list` shows all")
        return ListGroupsResponse(success=not problem, message=problem, groups=groups)


class _ListedGroup(NamedTuple):
    info: GroupInfo
    members: tuple[str, ...]


def list_groups(devices: Sequence[Device], queries: Mapping[str, str]) -> tuple[GroupInfo, ...]:
    """Return the groups among *devices*, and those of the owner with the *queries* for their members, by name."""
    names = part_names(devices)
    parts = [(device, part) for device in devices for part in device.parts]
    commanded = [(device, part) for device, part in parts if is_commanded(part.part) and not part.part.members]
    own = {
        name: [_place(*member) for member in commanded if name in groups_of(member[0], member[1].id)]
        for name in queries
    }
    listed = [_ListedGroup(GroupInfo(name=name, query=queries[name]), tuple(members)) for name, members in own.items()]
    listed += _native(parts, commanded)
    return tuple(
        sorted((_complete(group, listed, names) for group in listed), key=lambda info: (info.name.casefold(), info.id))
    )


def _native(
    parts: Iterable[tuple[Device, DevicePart]], commanded: Sequence[tuple[Device, DevicePart]]
) -> Iterator[_ListedGroup]:
    for device, part in parts:
        if not part.part.is_group:
            continue
        wanted, gateways = set(part.part.members), {route.gateway for route in part.routes}
        named, members = set[str](), list[str]()
        for candidate in commanded:
            if known := wanted.intersection(references(*candidate, gateways)):
                named |= known
                members.append(_place(*candidate))
        info = GroupInfo(name=group_name(device, part), id=target_of(device.id, part.id), is_complete=named == wanted)
        yield _ListedGroup(info, tuple(members))


def _complete(group: _ListedGroup, others: Iterable[_ListedGroup], names: Mapping[str, str]) -> GroupInfo:
    alike = [
        other.info.id
        for other in others
        if other.info.id and other.info.is_complete and group.members and set(other.members) == set(group.members)
    ]
    members = tuple(
        [
            KeyValue(key=member, value=names.get(member) or names.get(member.partition("#")[0], ""))
            for member in group.members
        ]
    )
    return group.info.model_copy(update={"members": members, "reached_by": tuple(alike)})


def _place(device: Device, part: DevicePart) -> str:
    return target_of(device.id, part.id)
