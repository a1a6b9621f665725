"""Services with which the owner approves dangerous devices, and trusts those that a witness contradicted."""

from homebot.devices.device import KeyValue
from homebot.messages.message import Message, ServiceAnswer, ServiceType


class ApproveDeviceRequest(Message):
    """Approve a device, so that it may be driven; the directory remembers this across restarts.

    Attributes:
        remove: Whether to withdraw the approval instead.
        is_preview: Whether to change nothing: the answer shows the would-be approval.
        digest: The digest in the answer to a preview: announcements that changed since are not approved. Empty for the
            present announcements.
    """

    device: str
    remove: bool = False
    is_preview: bool = False
    digest: str = ""


class ApproveDeviceResponse(ServiceAnswer):
    """The result of an approval.

    Attributes:
        commands: The approved commands, one line for each setting: address and payload.
        changes: Differences from the previous approval, one line for each part of an announcement.
        digest: For a preview: the digest of the announcements to approve.
    """

    commands: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()
    digest: str = ""


class ApprovedCommands(Message):
    """All approvals of the owner; the newest is kept for late joiners.

    Attributes:
        digests: The digest of each approved :class:`homebot.devices.part.CommandDescription`.
    """

    digests: tuple[str, ...] = ()


class DescribeCommandsRequest(Message):
    """Request for the messages that commands to a device would publish."""

    key: str


class DescribeCommandsResponse(Message):
    """The messages that commands to a device would publish, as text.

    Attributes:
        commands: One line for each setting, such as ``lock=unlocked: door/set UNLOCK``; empty if the gateway does not
            know such a device, or its protocol leaves no choice.
    """

    commands: tuple[str, ...] = ()


class UnapprovedRequest(Message):
    """Request for the dangerous devices that wait for approval.

    Attributes:
        device: The id of the only device to check; empty for all.
    """

    device: str = ""


class UnapprovedResponse(Message):
    """The devices that wait; none if no device needs an approval, as in a simulated house.

    Attributes:
        devices: Their ids, sorted.
        reasons: By id, why each device always asks; if one device was requested, also when it does not wait.
        limits: Of one requested device: by id, why each other part is not harmless (:mod:`homebot.devices.harmless`).
    """

    devices: tuple[str, ...] = ()
    reasons: tuple[KeyValue, ...] = ()
    limits: tuple[KeyValue, ...] = ()


class TrustDeviceRequest(Message):
    """Trust a device again."""

    device: str


class TrustDeviceResponse(Message):
    """The contradictions that no longer count.

    Attributes:
        witnesses: The names of the sensors that had contradicted a part of the device; empty if it was trusted.
    """

    witnesses: tuple[str, ...] = ()


ApproveDevice = ServiceType("homebot/srv/ApproveDevice", ApproveDeviceRequest, ApproveDeviceResponse)
DescribeCommands = ServiceType("homebot/srv/DescribeCommands", DescribeCommandsRequest, DescribeCommandsResponse)
GetUnapproved = ServiceType("homebot/srv/GetUnapproved", UnapprovedRequest, UnapprovedResponse)
TrustDevice = ServiceType("homebot/srv/TrustDevice", TrustDeviceRequest, TrustDeviceResponse)
