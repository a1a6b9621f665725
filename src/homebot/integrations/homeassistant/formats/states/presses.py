"""Events of Home Assistant that are presses: commands of remotes, actions of its apps, and tags that these read. Pure.

Source: Home Assistant core 2026.11, ``components/zha/core/const.py``, ``components/deconz/deconz_event.py`` and
``components/tag``; the documentation of its companion apps, iOS actions.
"""

from collections.abc import Mapping
from typing import Final, NamedTuple

from homebot.conventions.payload import as_fields, text_of
from homebot.devices.part import Capability, Part


class AppEvent(NamedTuple):
    """An event of the apps of Home Assistant: the field that names it, and the part of their device that tells it."""

    field: str
    part: str


APP_EVENTS: Final[Mapping[str, AppEvent]] = {
    "ios.action_fired": AppEvent("actionName", "action"),
    "tag_scanned": AppEvent("tag_id", "tag"),
}
REMOTE_EVENTS: Final[Mapping[str, str]] = {"zha_event": "command", "deconz_event": "event"}
"""The fields with the press; in ``device_id`` is the device."""

APP_KEY: Final = "home_assistant_app"
"""The key of the device that all apps are."""

RAW_PART: Final = "event"
"""The part of a remote that tells its events as they come."""


def open_button(part_id: str, advertised: str) -> Part:
    """Return a button of which it is not known what it tells."""
    press = Capability(name="press")
    return Part(id=part_id, service_type="generic_switch", advertised=advertised, tag=part_id, capabilities=(press,))


APP_PARTS: Final = tuple(open_button(event.part, kind) for kind, event in APP_EVENTS.items())


class Pressed(NamedTuple):
    """A press that an event tells: the key of a device, the id of its part, and what happened."""

    key: str
    part: str
    press: str


def read_pressed(event: Mapping[str, object]) -> Pressed | None:
    """Return the press that *event* tells; None if it names none."""
    kind, data = text_of(event.get("event_type")), as_fields(event.get("data"))
    if (app := APP_EVENTS.get(kind)) is not None:
        pressed = Pressed(APP_KEY, app.part, text_of(data.get(app.field)))
    else:
        told = data.get(REMOTE_EVENTS.get(kind, ""))
        pressed = Pressed(text_of(data.get("device_id")), RAW_PART, str(told) if isinstance(told, str | int) else "")
    return pressed if pressed.key and pressed.press else None
