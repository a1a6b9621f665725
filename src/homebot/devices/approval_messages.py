"""The services by which the owner approves devices that can hurt, and trusts those that a witness contradicted."""

from homebot.devices.device import KeyValue
from homebot.messages.message import Message, ServiceAnswer, ServiceType

__all__ = ["ApproveDevice", "DescribeCommands", "GetUnapproved", "TrustDevice"]


class ApproveDeviceRequest(Message):
    """Approve a device, so that it may be driven; the directory remembers that over a restart.

    Attributes:
        remove: Whether to take the approval back instead.
        is_preview: Whether to change nothing: the answer shows what would be approved.
        digest: The digest in the answer to a preview: what is announced otherwise by then is not approved. Empty for
            what is announced now.
    """

    device: str
    remove: bool = False
    is_preview: bool = False
    digest: str = ""


class ApproveDeviceResponse(ServiceAnswer):
    """The result of an approval.

    Attributes:
        commands: The approved commands, one line for each setting: address and payload.
        changes: Differences from the approval before, one line for each part of an announcement.
        digest: Of a preview: the digest of what would be approved.
    """

    commands: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()
    digest: str = ""


class DescribeCommandsRequest(Message):
    """A request for the publications for commands to a device."""

    key: str


class DescribeCommandsResponse(Message):
    """Publications for the commands of a device, as text.

    Attributes:
        commands: One line for each setting, such as ``lock=unlocked: door/set UNLOCK``; empty if the gateway does not
            know such a device, or its protocol leaves no choice.
    """

    commands: tuple[str, ...] = ()


class UnapprovedRequest(Message):
    """A question for the devices that can hurt and wait for approval.

    Attributes:
        device: The id of the only one that matters; empty for all.
    """

    device: str = ""


class UnapprovedResponse(Message):
    """The devices that wait; none if no device needs an approval, as in a simulated house.

    Attributes:
        devices: Their ids, sorted.
        reasons: By id, why each of them always asks; also of a device that does not wait if it was asked about.
    """

    devices: tuple[str, ...] = ()
    reasons: tuple[KeyValue, ...] = ()


class TrustDeviceRequest(Message):
    """Trust a device again."""

    device: str


class TrustDeviceResponse(Message):
    """The contradictions that count no more.

    Attributes:
        witnesses: The names of the sensors that had contradicted a part of the device; empty if it was trusted.
    """

    witnesses: tuple[str, ...] = ()


ApproveDevice = ServiceType("homebot/srv/ApproveDevice", ApproveDeviceRequest, ApproveDeviceResponse)
DescribeCommands = ServiceType("homebot/srv/DescribeCommands", DescribeCommandsRequest, DescribeCommandsResponse)
GetUnapproved = ServiceType("homebot/srv/GetUnapproved", UnapprovedRequest, UnapprovedResponse)
TrustDevice = ServiceType("homebot/srv/TrustDevice", TrustDeviceRequest, TrustDeviceResponse)
