"""Routines: rules of the owner as data, each of which is an app."""

from typing import Final

from homebot.feature import Feature, FeatureTable, Verb
from homebot.rights import OfferedService, Right

LIST_ROUTINES: Final = OfferedService("/routines/list", Right.READ, "homebot/srv/ListRoutines")
CHANGE_ROUTINE: Final = OfferedService("/routines/change", Right.MANAGE, "homebot/srv/ChangeRoutine")
PROPOSE_ROUTINE: Final = OfferedService("/routines/propose", Right.ACT, "homebot/srv/ProposeRoutine")
ROUTINE_GALLERY: Final = OfferedService("/routines/gallery", Right.READ, "homebot/srv/ReadRoutineGallery")
ROUTINE_SENTENCES: Final = OfferedService("/routines/sentences", Right.READ, "homebot/srv/ListRoutineSentences")

KEPT_ROUTINES: Final = "routines"
"""The store of the routines that the owner wrote by a command."""

FEATURE: Final = Feature(
    name="routines",
    server="homebot.features.routines.routine_services:start",
    services=(LIST_ROUTINES, CHANGE_ROUTINE, PROPOSE_ROUTINE, ROUTINE_GALLERY, ROUTINE_SENTENCES),
    stores=(KEPT_ROUTINES,),
    keeps_apps="routine",
    tables={
        "routines": FeatureTable(
            "homebot.features.routines.tables:apps_of_routines",
            is_array=True,
            section="apps",
            plugin="homebot.features.routines.routine:Routine",
            was="homebot.routines.routine:Routine",
            check="homebot.features.routines.tables:check_routine",
        )
    },
    verbs={
        "bind": Verb(
            "let a button do something", "homebot.features.routines.command_binding:add_arguments", after="app"
        ),
        "routine": Verb(
            "list and show routines, start them, switch them on and off",
            "homebot.features.routines.command:add_arguments",
            after="bind",
        ),
    },
    routes="homebot.features.routines.http:ROUTES",
    tools="homebot.features.routines.agent_tools:add_tools",
    explains="homebot.features.routines.command:show",
    adds_to_why="homebot.features.routines.why:sent_robot",
    adds_to_why_not="homebot.features.routines.why:held_back",
)
