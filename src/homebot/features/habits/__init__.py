"""Habits of the people in a house, found in recorded days; each is proposed as a routine, with its proof."""

from typing import Final

from homebot.feature import Feature, Verb
from homebot.rights import OfferedService, Right

SUGGEST_HABITS: Final = OfferedService("/habits/suggest", Right.READ, "homebot/srv/SuggestHabits")
DECIDE_HABIT: Final = OfferedService("/habits/decide", Right.MANAGE, "homebot/srv/DecideHabit")

FEATURE: Final = Feature(
    name="habits",
    server="homebot.features.habits.habit_services:start",
    services=(SUGGEST_HABITS, DECIDE_HABIT),
    verbs={
        "suggest": Verb(
            "propose routines of what people in the house do, with proof; accept or reject one",
            "homebot.features.habits.command:add_arguments",
            after="routine",
        )
    },
    messages=("homebot.features.habits.messages",),
    routes="homebot.features.habits.http:ROUTES",
    tools="homebot.features.habits.agent_tools:add_tools",
)
