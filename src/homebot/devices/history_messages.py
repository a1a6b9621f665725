"""Services that read the history of devices: measurements, states, and energy by day."""

from typing import Annotated, Final, Literal

from pydantic import Field

from homebot.devices.query.term_messages import QueryTerm
from homebot.devices.value import ShortText
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType, UInt32

MAX_POINTS = 5000
"""The largest number of points of a series in one answer."""

_NO_TIME = Time(sec=0, nanosec=0)


class ReadHistoryRequest(Message):
    """Request for the history of devices.

    Attributes:
        device: The id of the device, even if it is gone; empty for those of the *query*.
        query: The query for devices, as terms; external programs may send it as text. If it contains a capability, as
            in ``temperature in kitchen``, the answer has only that capability.
        part: The id of the part; empty for all.
        capability: The name of the capability; empty for all except those of settings and diagnostics.
        since: The start; 0 for a day before the end.
        until: The end; 0 for now.
        points: The largest number of points of a series; 0 for 500.
    """

    device: ShortText = ""
    query: tuple[QueryTerm, ...] = ()
    part: ShortText = ""
    capability: ShortText = ""
    since: Time = _NO_TIME
    until: Time = _NO_TIME
    points: Annotated[UInt32, Field(le=MAX_POINTS)] = 0


class HistorySeries(Message):
    """The history of one value of a device: either numbers, or words and flags.

    Attributes:
        name: The name of the device; its id if it is gone.
        unit: The unit of the numbers; empty if there is none.
        width: Seconds that each point summarizes; 0 if each is a single value.
        times: Seconds since the Unix epoch: when each value was reported, or the start of the period that it
            summarizes. In a pause the value was unknown.
        values: The numbers, or their means.
        lows: The smallest numbers; empty if each point is a single value.
        highs: The largest numbers; empty if each point is a single value.
        words: The words in place of numbers; ``true`` and ``false`` for a flag.
        ends: When each word ended; the end of the answer if it lasts, and its own time for an event.
        complete: Whether these are all values; otherwise they are the newest.
    """

    device: str
    name: str
    part: str
    capability: str
    unit: str = ""
    width: float = 0.0
    times: tuple[float, ...] = ()
    values: tuple[float, ...] = ()
    lows: tuple[float, ...] = ()
    highs: tuple[float, ...] = ()
    words: tuple[str, ...] = ()
    ends: tuple[float, ...] = ()
    complete: bool = True


class ReadHistoryResponse(ServiceAnswer):
    """The history of the devices that fit.

    Attributes:
        series: The values, by device, part and capability; numbers and words of one capability are separate.
        left_out: The number of further series that fit, but not in one answer.
    """

    series: tuple[HistorySeries, ...] = ()
    left_out: UInt32 = 0
    since: Time = _NO_TIME
    until: Time = _NO_TIME


METER_OF_THE_HOUSE: Final = "house meter"
"""The owner's tag of the meter that counts the others too: it is in no sum of rooms."""


class ReadEnergyRequest(Message):
    """Request for the energy by day, hour or month.

    Attributes:
        device: The id of the device; empty for those of the *query*.
        query: The query for devices, as for :class:`ReadHistoryRequest`.
        since: The start, rounded down to midnight; 0 for six days before the end.
        until: The end; 0 for now.
        step: The time of each sum.
        by: Whether the sums are of each device, of each room, or of all; the last two without the meter of the house
            (:data:`METER_OF_THE_HOUSE`).
    """

    device: ShortText = ""
    query: tuple[QueryTerm, ...] = ()
    since: Time = _NO_TIME
    until: Time = _NO_TIME
    step: Literal["day", "hour", "month"] = "day"
    by: Literal["device", "room", "all"] = "device"


class EnergyOfDay(Message):
    """The energy that one meter counted in one day of the home's time zone.

    Attributes:
        day: The date, as in ISO 8601; of an hour with its start, ``2026-03-28T14+01:00``; of a month ``2026-03``.
        device: The id of the device; empty in sums.
        name: The name of the device, its id if it is gone; in sums by room that of the room, empty for none.
        used: The energy that was used, in kWh.
        returned: The energy that was returned to the grid, in kWh.
    """

    day: str
    device: str
    name: str
    part: str = ""
    used: float = 0.0
    returned: float = 0.0


class ReadEnergyResponse(ServiceAnswer):
    """The energy by day and device, without days on which nothing was counted."""

    days: tuple[EnergyOfDay, ...] = ()


ReadHistory = ServiceType("homebot/srv/ReadHistory", ReadHistoryRequest, ReadHistoryResponse)
ReadEnergy = ServiceType("homebot/srv/ReadEnergy", ReadEnergyRequest, ReadEnergyResponse)


class CorrectHistoryRequest(Message):
    """Request to correct the stored numbers of one value of a device, which other nodes than the history never change.

    Attributes:
        device: The id of the device, even if it is gone.
        part: The id of the part; empty for the only one with the capability.
        since: The start.
        until: The end, which is not corrected.
        value: In place of the numbers, unless *drops*.
        drops: Whether the numbers are dropped.
    """

    device: ShortText
    part: ShortText = ""
    capability: ShortText
    since: Time
    until: Time
    value: float = 0.0
    drops: bool = False


class CorrectHistoryResponse(ServiceAnswer):
    """The answer to a correction.

    Attributes:
        count: How many numbers and summaries were corrected.
    """

    count: UInt32 = 0


CorrectHistory = ServiceType("homebot/srv/CorrectHistory", CorrectHistoryRequest, CorrectHistoryResponse)
