"""Scenes: values of several devices under one name; those of the owner, and those that bridges keep."""

from typing import Final

from homebot.feature import Feature, FeatureTable, Verb
from homebot.rights import OfferedService, Right

LIST_SCENES: Final = OfferedService("/scenes/list", Right.READ, "homebot/srv/ListScenes")
CHANGE_SCENE: Final = OfferedService("/scenes/change", Right.MANAGE, "homebot/srv/ChangeScene")
APPLY_SCENE: Final = OfferedService("/scenes/apply", Right.ACT, "homebot/srv/ApplyScene", waits=True)

FEATURE: Final = Feature(
    name="scenes",
    server="homebot.features.scenes.scene_services:start",
    services=(LIST_SCENES, CHANGE_SCENE, APPLY_SCENE),
    tables={"scenes": FeatureTable("homebot.features.scenes.settings:read_scenes", is_array=True, is_live=True)},
    verbs={
        "scene": Verb(
            "save, apply, undo and change scenes: values of several devices under one name",
            "homebot.features.scenes.command:add_arguments",
            after="suggest",
        )
    },
    routes="homebot.features.scenes.http:ROUTES",
    tools="homebot.features.scenes.agent_tools:add_tools",
    explains="homebot.features.scenes.command:show",
)
