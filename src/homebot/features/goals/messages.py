"""Action and service that achieve a goal in words by a plan, such as ``kitchen lit and rosie in kitchen``."""

from typing import Annotated

from pydantic import Field

from homebot.messages.action import ActionType
from homebot.messages.message import Message, ServiceAnswer, ServiceType


class AchieveRequest(Message):
    """A goal in words.

    Attributes:
        goal: States joined by ``and``: ``kitchen lit``, ``hall dark``, ``rosie in kitchen``, ``front door closed``.
        is_dry_run: Whether only to plan.
        issuer: The name of the node, or ``client:NAME`` for a client of the door, set by the door.
        scope: As for :class:`homebot.devices.command_messages.CommandRequest`.
    """

    goal: Annotated[str, Field(max_length=1000)]
    is_dry_run: bool = False
    issuer: str = ""
    scope: Annotated[tuple[str, ...], Field(max_length=100)] = ()


class PlannedStep(Message):
    """A step of a plan.

    Attributes:
        text: The step in words.
        asks: The reason to ask a person first; empty for none.
        outcome: How it ended; empty until then.
    """

    text: str
    asks: str = ""
    outcome: str = ""


class AchieveResponse(ServiceAnswer):
    """The plan; a success if the goal is reached or, in a dry run, if the plan would reach it.

    The message names the fact that is in the way, if there is one.

    Attributes:
        steps: Those done, also of earlier plans, and the last plan, with outcomes.
        tried: The failures of earlier plans.
    """

    steps: tuple[PlannedStep, ...] = ()
    tried: tuple[str, ...] = ()


class AchieveGoal(AchieveRequest, ros_type="homebot/action/Achieve_Goal"):
    """A goal in words, with the fields of the service ``/devices/achieve_words``."""


class AchieveResult(AchieveResponse, ros_type="homebot/action/Achieve_Result"):
    """The plan with its outcomes, as for that service."""


class AchieveFeedback(Message, ros_type="homebot/action/Achieve_Feedback"):
    """The plan before its first step, after each step, and when it is made anew."""

    steps: tuple[PlannedStep, ...]
    tried: tuple[str, ...] = ()


Achieve = ActionType("homebot/action/Achieve", AchieveGoal, AchieveResult, AchieveFeedback)
AchieveWords = ServiceType("homebot/srv/AchieveWords", AchieveRequest, AchieveResponse)
