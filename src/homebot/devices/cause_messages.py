"""Service of the control layer that tells whose doing the newest change of each value was."""

from homebot.devices.value import Value
from homebot.messages.message import Message, ServiceAnswer, ServiceType

__all__ = ["GetCauses", "GetCausesRequest", "KnownCause", "KnownCauses"]


class GetCausesRequest(Message):
    """Request for the causes of the values of some devices.

    Attributes:
        from_journal: Whether to look in the journal for changes that came before this homebot started.
    """

    devices: tuple[str, ...]
    from_journal: bool = False


class KnownCause(Message):
    """The cause of the newest change of a value.

    Attributes:
        value: The value since that change.
        command: The id of the command behind it; empty for none.
        issuer: Who gave that command; empty if that is not known.
        may_be_person: Whether it has to be treated as a person's action.
    """

    device: str
    part: str
    capability: str
    value: Value
    command: str
    may_be_person: bool
    issuer: str = ""


class KnownCauses(ServiceAnswer):
    """The known causes; a part that has neither changed nor been commanded has none."""

    success: bool = True
    causes: tuple[KnownCause, ...] = ()


GetCauses = ServiceType("homebot/srv/GetCauses", GetCausesRequest, KnownCauses)
