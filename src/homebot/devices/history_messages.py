"""Services that read the history of devices: measurements, states, and energy by day."""

from typing import Annotated

from pydantic import Field

from homebot.devices.query.term_messages import QueryTerm
from homebot.devices.value import ShortText
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType, UInt32

__all__ = [
    "MOST_POINTS",
    "EnergyOfDay",
    "HistorySeries",
    "ReadEnergy",
    "ReadEnergyRequest",
    "ReadEnergyResponse",
    "ReadHistory",
    "ReadHistoryRequest",
    "ReadHistoryResponse",
]

MOST_POINTS = 5000
"""Points of a series in one answer."""

_NO_TIME = Time(sec=0, nanosec=0)


class ReadHistoryRequest(Message):
    """A question for the history of devices.

    Attributes:
        device: The id of the device, also of one that is gone; empty for those of the *query*.
        query: The query for devices, as terms; programs outside may send it as text. A capability in it, as in
            ``temperature in kitchen``, is the only one in the answer.
        part: The id of the part; empty for all.
        capability: The name of the capability; empty for all, but those of settings and self-observations.
        since: The begin; 0 for a day before the end.
        until: The end; 0 for now.
        points: The number of points of a series at most; 0 for 500.
    """

    device: ShortText = ""
    query: tuple[QueryTerm, ...] = ()
    part: ShortText = ""
    capability: ShortText = ""
    since: Time = _NO_TIME
    until: Time = _NO_TIME
    points: Annotated[UInt32, Field(le=MOST_POINTS)] = 0


class HistorySeries(Message):
    """The history of one value of a device: numbers, or words and flags.

    Attributes:
        name: The name of the device; its id if it is gone.
        unit: The unit of the numbers; empty if there is none.
        width: Seconds that each point summarizes; 0 if each is a single value.
        times: Seconds since the Unix epoch: of each value, or of the begin of the time that it summarizes. A pause is
            a time in which the value was unknown.
        values: The numbers, or their means.
        lows: The smallest numbers; empty if each point is a single value.
        highs: The largest numbers, likewise.
        words: In place of numbers: the words; ``true`` and ``false`` of a flag.
        ends: The end of each word; the end of the answer if it lasts.
        complete: Whether these are all; otherwise the newest.
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
        series: The values, by device, part and capability; numbers and words of one each apart.
        left_out: Further series that fit, which are too many for one answer.
    """

    series: tuple[HistorySeries, ...] = ()
    left_out: UInt32 = 0
    since: Time = _NO_TIME
    until: Time = _NO_TIME


class ReadEnergyRequest(Message):
    """A question for the energy by day.

    Attributes:
        device: The id of the device; empty for those of the *query*.
        query: The query for devices, as of :class:`ReadHistoryRequest`.
        since: The begin, from the midnight before it on; 0 for six days before the end.
        until: The end; 0 for now.
    """

    device: ShortText = ""
    query: tuple[QueryTerm, ...] = ()
    since: Time = _NO_TIME
    until: Time = _NO_TIME


class EnergyOfDay(Message):
    """The energy that one meter counted in one day of the home.

    Attributes:
        day: The date, as in ISO 8601.
        name: The name of the device; its id if it is gone.
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
    """The energy by day and device; not of days on which nothing was counted."""

    days: tuple[EnergyOfDay, ...] = ()


ReadHistory = ServiceType("homebot/srv/ReadHistory", ReadHistoryRequest, ReadHistoryResponse)
ReadEnergy = ServiceType("homebot/srv/ReadEnergy", ReadEnergyRequest, ReadEnergyResponse)
