"""Messages and services of a gateway of NFC tags and QR codes, which point to devices."""

from typing import Annotated, ClassVar, Literal, TypeAlias

from pydantic import Field

from homebot.devices.device import KeyValue
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType

TagProblem: TypeAlias = Literal[
    "",
    "busy",
    "lost",
    "no_device",
    "no_reader",
    "no_tag",
    "not_a_tag",
    "protected",
    "refused",
    "too_small",
    "unreadable",
]
"""The reason why a tag was not read or written; empty if it was."""

_Wait: TypeAlias = Annotated[float, Field(ge=0, le=600)]
_MAX_CODE = 8192


class TagTap(Message):
    """Event: a tag was held to a reader.

    Attributes:
        tag: Its number in hexadecimal digits, which is its key in the gateway.
        points_to: The pointer on the tag, in words.
        device: The id of the device that it points to; empty if there is none, or several.
        candidates: The ids of all devices that it may mean.
        area: The room of the tag, from the settings or the tag itself; empty if unknown.
    """

    key_field: ClassVar[str | None] = "tag"

    tag: str
    reader: str
    points_to: str = ""
    device: str = ""
    candidates: tuple[str, ...] = ()
    area: str = ""
    tapped_at: Time


class ScanCodeRequest(Message):
    """Request for the device that a code points to.

    Attributes:
        ndef: An NDEF message, instead of the text.
    """

    text: Annotated[str, Field(max_length=_MAX_CODE)] = ""
    ndef: Annotated[bytes, Field(max_length=_MAX_CODE)] = b""


class ScanCodeResponse(ServiceAnswer):
    """The device that a code points to; a success if the code was understood, even if the device is unknown.

    Attributes:
        kind: The kind of code: ``homebot``, ``thing``, ``mqtt``, ``url``, ``text``, or that of a setup code, such as
            ``matter``.
        device: The id of the device; empty if there is none, or several.
        candidates: The ids of all devices that it may mean.
        area: The room that it names; empty for none.
        facts: Further facts in the code, without secrets.
    """

    kind: str = ""
    device: str = ""
    candidates: tuple[str, ...] = ()
    area: str = ""
    facts: tuple[KeyValue, ...] = ()


class ReadTagRequest(Message):
    """Request to read the tag at a reader, or the next one.

    Attributes:
        reader: The reader; empty for any.
        wait: Seconds to wait for a tag.
    """

    reader: str = ""
    wait: _Wait = 30.0


class ReadTagResponse(ServiceAnswer):
    """The tag.

    Attributes:
        problem: The reason if not, for programs.
        tag: Its number in hexadecimal digits.
        device: The id of the device that it points to; empty if there is none, or several.
        candidates: The ids of all devices that it may mean.
        area: The room of the tag; empty if unknown.
    """

    problem: TagProblem = ""
    tag: str = ""
    reader: str = ""
    tag_type: str = ""
    ndef: bytes = b""
    device: str = ""
    candidates: tuple[str, ...] = ()
    area: str = ""


class WriteTagRequest(Message):
    """Request to write a pointer to a device to the tag at a reader, or the next one; its content is replaced.

    Attributes:
        device: The id or the name of the device.
        area: The room of the tag, which is also written to it; empty for none.
        reader: The reader; empty for any.
        wait: Seconds to wait for a tag.
    """

    device: str
    area: Annotated[str, Field(max_length=100)] = ""
    reader: str = ""
    wait: _Wait = 30.0


class WriteTagResponse(ServiceAnswer):
    """The result of writing a tag; it was read back and compared.

    Attributes:
        problem: The reason if not, for programs.
        tag: Its number in hexadecimal digits.
        device: The id of the device that it points to now.
    """

    problem: TagProblem = ""
    tag: str = ""
    reader: str = ""
    device: str = ""


ScanCode = ServiceType("homebot/srv/ScanCode", ScanCodeRequest, ScanCodeResponse)
ReadTag = ServiceType("homebot/srv/ReadTag", ReadTagRequest, ReadTagResponse)
WriteTag = ServiceType("homebot/srv/WriteTag", WriteTagRequest, WriteTagResponse)
