"""Services for scenes: a name, and a value for each of a set of parts."""

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from homebot.devices.command_messages import MAX_SETTINGS, MAX_TRANSITION_S, CommandDevicesResponse, Setting
from homebot.devices.device import KeyValue
from homebot.devices.trigger import NO_TRIGGER, Trigger
from homebot.devices.value import ShortText
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message, ServiceAnswer, ServiceType

MAX_PARTS = 500
"""The limit of parts of one scene."""

_NO_TIME = Time(sec=0, nanosec=0)


class ScenePart(Message):
    """One part in a scene.

    Attributes:
        name: Its name for people; its id if it is not in the house.
        area: The room of its device; empty if unknown.
        settings: Its values; empty if only the source of a native scene knows them.
        text: The values in the words of ``homebot do``, such as ``on, level 20 %``.
        asks: Why it always asks; empty if it does not, or if the values only make the house safer.
        is_known: Whether it is in the house now.
    """

    device: ShortText
    part: ShortText = ""
    name: str = ""
    area: str = ""
    settings: Annotated[tuple[Setting, ...], Field(max_length=MAX_SETTINGS)] = ()
    text: str = ""
    asks: str = ""
    is_known: bool = True


class SceneInfo(Message):
    """A scene of the owner, or a native one, which a bridge or device keeps and one message recalls.

    Attributes:
        name: Its name; that of a native one may occur in several rooms.
        id: Its unique name in requests: its name, or the id of the part that recalls it.
        is_native: Whether a bridge or device keeps it.
        area: The room of a native one; empty if unknown.
        parts: The parts that it sets; empty if a native one does not tell them.
        is_configured: Whether it is in the configuration, where it is changed.
        problems: The devices of the configuration that cannot be set, with the reasons.
        can_undo: Whether it was applied, and not undone since.
        applied_at: When it was last applied by homebot; 0 if it was not.
    """

    name: str
    id: str
    is_native: bool = False
    area: str = ""
    parts: tuple[ScenePart, ...] = ()
    is_configured: bool = False
    problems: tuple[KeyValue, ...] = ()
    can_undo: bool = False
    applied_at: Time = _NO_TIME


class ScenesRequest(Message):
    """Request for the scenes.

    Attributes:
        name: The name or id of one; empty for all.
    """

    name: ShortText = ""


class ScenesResponse(ServiceAnswer):
    """The scenes, those of the owner first; fails if the named one is unknown."""

    scenes: tuple[SceneInfo, ...] = ()


SceneChange: TypeAlias = Literal["save", "edit", "rename", "remove"]


class ChangeSceneRequest(Message):
    """Request to change a scene of the owner; homebot remembers it across restarts.

    Attributes:
        name: Its name.
        change: ``save`` takes the present values of *target*, in place of an older scene of the name; ``edit`` sets
            *values*; ``rename`` gives it the name *target*; ``remove`` forgets it.
        target: The id or name of a device, or a query such as ``lights in living``; to save a known scene, empty for
            the same parts as before.
        values: The devices or queries, each with its values in the words of ``homebot do``, such as ``on, 20 %``, or
            ``now`` for the present ones; without a word it is left out of the scene.
        replaces: Whether the scene has only *values* then.
    """

    name: ShortText
    change: SceneChange
    target: ShortText = ""
    values: Annotated[tuple[KeyValue, ...], Field(max_length=MAX_PARTS)] = ()
    replaces: bool = False


class ChangeSceneResponse(ServiceAnswer):
    """The result.

    Attributes:
        scenes: The scene as it is now; empty if it was removed.
        left_out: The parts that were not saved, each with the reason.
    """

    scenes: tuple[SceneInfo, ...] = ()
    left_out: tuple[KeyValue, ...] = ()


class ApplySceneRequest(Message):
    """Request to apply a scene, or to bring back the values before it.

    Attributes:
        name: Its name or id.
        transition: Seconds that the changes take, where a device supports that.
        undo: Whether to bring back the values before it was applied last, where nothing else has changed them since.
        agreed: Whether the person at the client has agreed to the values of parts that always ask; otherwise people in
            the house are asked. An app cannot agree.
        unless_asks: Whether an undo does nothing if a person must agree first: ``asks`` of the answer says why.
        issuer: The issuer of the commands; the door sets it for its clients.
        scope: As for :class:`homebot.devices.command_messages.CommandRequest`.
        ask_first: Whether a person must agree to each command first.
        trigger: Its cause; only homebot's own nodes can say so.
    """

    name: ShortText
    transition: Annotated[float, Field(ge=0.0, le=MAX_TRANSITION_S)] = 0.0
    undo: bool = False
    agreed: bool = False
    unless_asks: bool = False
    issuer: str = ""
    scope: Annotated[tuple[str, ...], Field(max_length=100)] = ()
    ask_first: bool = False
    trigger: Trigger = NO_TRIGGER


ListScenes = ServiceType("homebot/srv/ListScenes", ScenesRequest, ScenesResponse)
ChangeScene = ServiceType("homebot/srv/ChangeScene", ChangeSceneRequest, ChangeSceneResponse)
ApplyScene = ServiceType("homebot/srv/ApplyScene", ApplySceneRequest, CommandDevicesResponse)
