"""The service that lists groups: names for several parts, of the owner and of gateways."""

from homebot.devices.device import KeyValue
from homebot.messages.message import Message, ServiceAnswer, ServiceType


class ListGroupsRequest(Message):
    """Request for the groups of the house.

    Attributes:
        name: Only the groups with this name or id, regardless of case; empty for all.
    """

    name: str = ""


class GroupInfo(Message):
    """One group.

    Attributes:
        query: The query for its members, for a group of the owner; empty for one that a gateway knows.
        id: The id of the device, with ``#`` and the id of the part if there are several, that a message to a gateway's
            group is sent to; empty for a group of the owner.
        members: The known ones by name: the id of the device, with ``#`` and the id of the part if that has one.
        is_complete: Whether all members are known that its gateway lists.
        reached_by: The ids of the gateways' groups with exactly the same members: a command to these is one message.
    """

    name: str
    query: str = ""
    id: str = ""
    members: tuple[KeyValue, ...] = ()
    is_complete: bool = True
    reached_by: tuple[str, ...] = ()


class ListGroupsResponse(ServiceAnswer):
    """The groups, by name; the call fails if none has the name of the request."""

    groups: tuple[GroupInfo, ...] = ()


ListGroups = ServiceType("homebot/srv/ListGroups", ListGroupsRequest, ListGroupsResponse)
