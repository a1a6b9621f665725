"""Questions and answers of the HTTP API. A field that is empty, or as it mostly is, is left out of an answer."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from homebot.bridges.home_api.problem import ProblemOutcome
from homebot.devices.command_messages import OutcomeKind
from homebot.devices.services import MOST_LISTED
from homebot.devices.value import ShortText

__all__ = [
    "CommandQuestion",
    "DeviceDetails",
    "DeviceLine",
    "DeviceList",
    "DeviceQuestion",
    "HistoryAnswer",
    "HistoryQuestion",
    "HomeAnswer",
    "ListQuestion",
    "NoQuestion",
    "OutcomeAnswer",
    "PartOutcome",
    "Problem",
    "ShortValue",
    "ValueSeries",
    "WhyAnswer",
    "WhyQuestion",
]

ShortValue: TypeAlias = bool | int | float | str | list[float]
"""A value; numbers have two decimal places."""

_Name: TypeAlias = Annotated[ShortText, Field(min_length=1)]


class _Question(BaseModel):
    model_config = ConfigDict(extra="forbid", defer_build=True, hide_input_in_errors=True)


class _Answer(BaseModel):
    model_config = ConfigDict(frozen=True, defer_build=True)


class NoQuestion(_Question):
    """Nothing to ask."""


class ListQuestion(_Question):
    """A query for devices, such as `light in kitchen`; empty for all."""

    q: Annotated[str, Field(max_length=1000)] = ""
    limit: Annotated[int, Field(ge=1, le=MOST_LISTED)] = 50


class DeviceQuestion(_Question):
    """A device by its id or name."""

    id: _Name


class WhyQuestion(DeviceQuestion):
    """A device, and a state that it is not in; empty to ask why it is as it is."""

    state: Annotated[str, Field(max_length=100)] = ""


class HistoryQuestion(_Question):
    """A device, a capability (empty for all), and the length of time, such as `24h` or `7d`."""

    device: _Name
    capability: ShortText = ""
    since: Annotated[str, Field(max_length=40)] = "24h"
    points: Annotated[int, Field(ge=1, le=500)] = 50


class CommandQuestion(_Question):
    """A command in words to one device: `on`, `40 %`, `level 40`, `unlock`."""

    device: _Name
    do: Annotated[str, Field(min_length=1, max_length=300)]


class DeviceLine(_Answer):
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


class DeviceList(_Answer):
    """Devices, and how many more fit."""

    devices: tuple[DeviceLine, ...]
    more: int = 0


class DeviceDetails(DeviceLine):
    """A device, with what it takes, and why it always asks a person."""

    state: str = ""
    takes: dict[str, str] = {}
    always_asks: str = ""
    last_seen: str = ""


class HomeAnswer(_Answer):
    """The house in short: the number of devices by room and type."""

    home: str = ""
    devices: int
    rooms: dict[str, dict[str, int]]
    unreachable: tuple[str, ...] = ()
    waiting_for_approval: tuple[str, ...] = ()


class PartOutcome(_Answer):
    """The outcome of a command for one part of a device."""

    part: str
    outcome: OutcomeKind
    text: str


class OutcomeAnswer(_Answer):
    """The outcome of a command, the worst of all parts, with its evidence or reason."""

    id: str
    name: str
    outcome: OutcomeKind
    text: str
    evidence: str = ""
    policy: str = ""
    reason: str = ""
    command_id: str = ""
    parts: tuple[PartOutcome, ...] = ()


class WhyAnswer(_Answer):
    """The reason for a state and the steps that led to it; `is_so` and `asked` where a state was named."""

    id: str
    state: str
    since: str = ""
    why: str
    is_so: bool | None = None
    asked: tuple[str, ...] = ()
    steps: tuple[str, ...] = ()
    more: int = 0


class ValueSeries(_Answer):
    """The values of a capability with their times; of numbers the mean of `width` seconds each if that is not 0."""

    capability: str
    part: str = ""
    unit: str = ""
    width: float = 0.0
    points: tuple[tuple[str, ShortValue], ...]


class HistoryAnswer(_Answer):
    """The history of a device, and how many more series there are."""

    id: str
    series: tuple[ValueSeries, ...]
    more: int = 0


class Problem(_Answer):
    """A request that was not carried out (RFC 9457)."""

    title: str
    status: int
    outcome: ProblemOutcome
    detail: str
    policy: str = ""
