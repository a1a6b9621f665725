"""Services for the habits of the people in a house, which are proposed as routines."""

from typing import Annotated

from pydantic import Field

from homebot.devices.app_messages import ChangeRoutineResponse
from homebot.devices.value import ShortText
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType, UInt32

_NO_TIME = Time(sec=0, nanosec=0)


class HabitOccasion(Message):
    """One time at which the routine would have acted.

    Attributes:
        done_at: When a person did the same; 0 if nobody did.
    """

    at: Time
    done_at: Time = _NO_TIME


class HabitProposal(Message):
    """A routine that would act as people do, or one of these that should be removed.

    Attributes:
        id: Its id, which stays the same as long as the habit does.
        removes: The name of a routine that people undo again and again; empty for a new one.
        text: Its table ``[[routines]]`` in TOML.
        proof: How often people did this in the trial, and the range of the precision, as a sentence.
        precision: The share of the occasions on which people do it, to be expected.
        precision_low: The least of that, with 95 % certainty.
        precision_high: The most of that, with 95 % certainty.
        trial_done: On how many occasions people did it in the week before, which was not used to find it.
        trial_total: The occasions of that week.
        recall: The share of the times that people do it that it covers.
        occasions: The newest hundred occasions, oldest first.
    """

    id: str
    name: str
    removes: str = ""
    when: str = ""
    conditions: tuple[str, ...] = ()
    do: str = ""
    text: str = ""
    proof: str
    precision: float = 0.0
    precision_low: float = 0.0
    precision_high: float = 0.0
    trial_done: UInt32 = 0
    trial_total: UInt32 = 0
    recall: float = 0.0
    occasions: tuple[HabitOccasion, ...] = ()


class SuggestHabitsRequest(Message):
    """Request for the habits of the last days.

    Attributes:
        days: How many days, of which the last seven are the trial; 0 for 28.
    """

    days: Annotated[UInt32, Field(le=60)] = 0


class SuggestHabitsResponse(ServiceAnswer):
    """The habits that no routine has and that nobody rejected.

    Attributes:
        watched: The names of those that are on trial, or in their first week.
        searched: The number of changes and presses that were searched.
        by_persons: How many of them persons brought about.
        left_out: How many older ones were too many.
        unnamed: The number of devices that are left out because their names are not unique.
        zone: The IANA name of the home's time zone; empty if it has none.
    """

    proposals: tuple[HabitProposal, ...] = ()
    watched: tuple[str, ...] = ()
    searched: UInt32 = 0
    by_persons: UInt32 = 0
    left_out: UInt32 = 0
    unnamed: UInt32 = 0
    zone: ShortText = ""


class DecideHabitRequest(Message):
    """Request to make a routine of a habit, or never to propose it again.

    Attributes:
        id: The id of its proposal.
        issuer: The client that asks; set by the door.
    """

    id: ShortText
    accept: bool
    issuer: str = ""


SuggestHabits = ServiceType("homebot/srv/SuggestHabits", SuggestHabitsRequest, SuggestHabitsResponse)
DecideHabit = ServiceType("homebot/srv/DecideHabit", DecideHabitRequest, ChangeRoutineResponse)
