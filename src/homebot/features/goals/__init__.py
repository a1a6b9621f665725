"""Goals in words that become plans: facts of the house, operators on it, a planner, and the steps with outcomes."""

from typing import Final

from homebot.feature import Feature, Verb
from homebot.rights import OfferedService, Right

ACHIEVE: Final = OfferedService("/devices/achieve", Right.ACT, "homebot/action/Achieve")
ACHIEVE_WORDS: Final = OfferedService("/devices/achieve_words", Right.ACT, "homebot/srv/AchieveWords", waits=True)

CUT_OFF_GOALS: Final = "goals/cut_off"
"""The store of goals under way."""

FEATURE: Final = Feature(
    name="goals",
    server="homebot.features.goals.achieve_server:start",
    services=(ACHIEVE, ACHIEVE_WORDS),
    stores=(CUT_OFF_GOALS,),
    verbs={
        "achieve": Verb(
            "plan how to reach a goal such as 'kitchen lit and rosie in kitchen', and do it",
            "homebot.features.goals.command:add_arguments",
            after="do",
        )
    },
    messages=("homebot.features.goals.messages",),
    routes="homebot.features.goals.http:ROUTES",
    tools="homebot.features.goals.agent_tools:add_tools",
    causes={"goal": "the goal {text!r} needs it"},
)
