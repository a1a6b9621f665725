"""Questions, answers and problems of the HTTP API. A field that is empty, or as it mostly is, is left out."""

from collections.abc import Mapping
from http import HTTPStatus
from typing import Annotated, Final, Literal, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from homebot.devices.command_messages import OutcomeKind
from homebot.devices.services import MAX_LISTED
from homebot.devices.value import ShortText
from homebot.errors import HomebotError
from homebot.support.printable import printable

ShortValue: TypeAlias = bool | int | float | str | list[float]
"""A value; numbers have two decimal places."""

ProblemOutcome: TypeAlias = Literal["refused", "not_found", "several", "invalid", "failed"]

PrintableText: TypeAlias = Annotated[str, AfterValidator(lambda text: printable(text, 1000))]
"""A text in which devices may have words of their own: bounded, and in one line."""

PROBLEMS: Mapping[HTTPStatus, ProblemOutcome] = {
    HTTPStatus.BAD_REQUEST: "invalid",
    HTTPStatus.UNAUTHORIZED: "refused",
    HTTPStatus.FORBIDDEN: "refused",
    HTTPStatus.NOT_FOUND: "not_found",
    HTTPStatus.METHOD_NOT_ALLOWED: "invalid",
    HTTPStatus.CONFLICT: "several",
    HTTPStatus.UNSUPPORTED_MEDIA_TYPE: "invalid",
    HTTPStatus.TOO_MANY_REQUESTS: "refused",
    HTTPStatus.SERVICE_UNAVAILABLE: "failed",
}
"""The word for each status."""

MAX_COMMANDED: Final = 50
"""Devices of one command."""

ShortName: TypeAlias = Annotated[ShortText, Field(min_length=1)]
_Names: TypeAlias = Annotated[tuple[ShortName, ...], Field(min_length=1, max_length=MAX_COMMANDED)]


class ProblemError(HomebotError):
    """A request that cannot be carried out.

    Attributes:
        allow: With 405, the methods of the address.
    """

    def __init__(self, status: HTTPStatus, detail: str, allow: str = "") -> None:
        super().__init__(detail)
        self.status = status
        self.allow = allow


class Question(BaseModel):
    """A question, in which an unknown field is a mistake."""

    model_config = ConfigDict(extra="forbid", defer_build=True, hide_input_in_errors=True)


class Answer(BaseModel):
    """An answer."""

    model_config = ConfigDict(frozen=True, defer_build=True)


class NoQuestion(Question):
    """Nothing to ask."""


class ListQuestion(Question):
    """A query for devices, such as `light in kitchen`; empty for all."""

    q: Annotated[str, Field(max_length=1000)] = ""
    limit: Annotated[int, Field(ge=1, le=MAX_LISTED)] = 50


class DeviceQuestion(Question):
    """A device by its id or name."""

    id: ShortName


class WhyQuestion(DeviceQuestion):
    """A device, and a state that it is not in; empty to ask why it is as it is."""

    state: Annotated[str, Field(max_length=100)] = ""


class JournalQuestion(Question):
    """A length of time up to now, such as `12h`, and a device; empty for all."""

    since: Annotated[str, Field(max_length=40)] = "12h"
    device: ShortText = ""
    limit: Annotated[int, Field(ge=1, le=MAX_LISTED)] = 50


class CommandQuestion(Question):
    """A command in words to one device, or to each of several: `on`, `40 %`, `level 40`, `unlock`.

    With `ask`, a person in the house must agree first, as to all that the token has the right `ask` for.
    """

    device: ShortName | _Names
    do: Annotated[str, Field(min_length=1, max_length=300)]
    ask: bool = False


class DeviceLine(Answer):
    """A device and its values, by capability: `on`, `level`, `temperature`; with several parts by `PART.CAPABILITY`."""

    model_config = ConfigDict(extra="allow")
    __pydantic_extra__: dict[str, ShortValue]

    id: str
    type: str
    room: str = ""
    name: str = ""
    reachable: bool = True
    freshness: str = "fresh"
    waits_for_approval: bool = False


class DeviceList(Answer):
    """Devices, how many more fit, and why there are none, or what they only nearly fit."""

    devices: tuple[DeviceLine, ...]
    more: int = 0
    note: PrintableText = ""


class DeviceDetails(DeviceLine):
    """A device, with its commands, why it always asks a person, and whether it was found by words of no name."""

    state: PrintableText = ""
    takes: dict[str, PrintableText] = {}
    always_asks: PrintableText = ""
    last_seen: str = ""
    by_words: bool = False


class HomeAnswer(Answer):
    """The house in short: the number of devices by room and type."""

    home: str = ""
    devices: int
    rooms: dict[str, dict[str, int]]
    unreachable: tuple[str, ...] = ()
    waiting_for_approval: tuple[str, ...] = ()


class OutcomeAnswer(Answer):
    """The outcome of a command, the worst of all parts, with its evidence or reason; of several devices the worst."""

    id: str
    outcome: OutcomeKind
    text: PrintableText
    evidence: str = ""
    policy: str = ""
    reason: PrintableText = ""
    command_id: str = ""
    parts: dict[str, PrintableText] = {}
    devices: "tuple[OutcomeAnswer, ...]" = ()


class WhyAnswer(Answer):
    """The reason for a state and the newest steps that led to it; where a state was named, the commands for that."""

    id: str
    state: PrintableText
    since: str = ""
    why: PrintableText
    is_so: bool | None = None
    steps: tuple[PrintableText, ...] = ()
    more: int = 0


class JournalAnswer(Answer):
    """The newest commands and changes by hand, in words, the oldest first; and whether older ones are left out."""

    entries: tuple[PrintableText, ...] = ()
    has_more: bool = False


class Problem(Answer):
    """A request that was not carried out (RFC 9457)."""

    title: str
    status: int
    outcome: ProblemOutcome
    detail: str
