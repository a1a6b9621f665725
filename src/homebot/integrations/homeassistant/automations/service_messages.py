"""Messages to people in automations, as steps of routines. Pure."""

from collections.abc import Iterator
from typing import Final

from homebot.integrations.homeassistant.automations.conditions import templates_of
from homebot.integrations.homeassistant.automations.entities import Automation, slug_of
from homebot.integrations.homeassistant.automations.event_triggers import message_button
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields, items_of
from homebot.support.located import Located
from homebot.words.steps import Notify, read_step

_COMMANDS: Final = ("command_", "request_location_update", "remove_channel", "delete_alert", "update_", "TTS")
"""Messages to the app of Home Assistant that are no messages to people, by their beginnings."""


def _is_clearing(data: UnreadFields) -> bool:
    """Return whether a message only clears an earlier one.

    Raises:
        NotCarriedError: It is a command to the phone.
    """
    node = data.left.get("message")
    text = str(node.value).strip() if node else ""
    if text.startswith(_COMMANDS):
        raise NotCarriedError(f"message {text!r}: a command to the phone; leave it out, or write a message")
    if text == "clear_notification":
        data.left.clear()
        return True
    return False


def message_steps(automation: Automation, name: str, data: UnreadFields) -> list[str] | None:
    """Return the steps of a service that tells people something; None for another one."""
    domain = name.partition(".")[0]
    if domain == "tts" or name == "assist_satellite.announce":
        return [_spoken(automation, name, data)]
    if domain == "notify" and _is_clearing(data):
        automation.notes.append("messages of homebot are not cleared")
        return []
    return [_message(automation, name, data)] if domain == "notify" or name in _MESSAGES else None


_FORMS: Final = ("parse_mode", "disable_notification", "config_entry_id")
_MESSAGES: Final = frozenset({"persistent_notification.create", "telegram_bot.send_message"})


def _spoken(automation: Automation, name: str, data: UnreadFields) -> str:
    """Return the message for a text that is spoken."""
    for key in ("media_player_entity_id", "cache", "language", "options", "preannounce"):
        data.take(key)
    automation.notes.append(f"{name} becomes a message to people: homebot does not speak")
    return _message(automation, name, data)


def _message(automation: Automation, name: str, data: UnreadFields) -> str:
    title, message = (_message_text(automation, data, key) for key in ("title", "message"))
    if not message:
        raise NotCarriedError(f"{name}: `message` is missing")
    if name == "persistent_notification.create":
        data.take("notification_id")
        automation.notes.append(f"{name} becomes a message to people")
    buttons = [f"[{name}]" for name in _buttons(automation, data.left.get("data"))]
    for key in ("data", "target", *_FORMS):
        if data.take(key) is not None:
            automation.notes.append(f"`{key}` of the message is left out")
    data.end()
    text = f"notify {' '.join(' '.join([': '.join(filter(None, (title, message))), *buttons]).split())}"
    if not isinstance(read_step(text), Notify):
        raise NotCarriedError(f"{name}: {message!r} is no message for a step")
    return text


def _buttons(automation: Automation, node: Located | None) -> Iterator[str]:
    """Yield the names of the buttons of a message, which are helpers; one that no automation asks for is left out."""
    known = node.value if node is not None and isinstance(node.value, dict) else {}
    for row in items_of(known.get("actions"), "actions"):
        fields = UnreadFields(row, "actions")
        if (action := fields.text("action")) == "URI":
            continue
        if automation.asks_for(action) or automation.entities.knows(f"input_button.{slug_of(action)}"):
            yield message_button(automation, action).device.name


def _message_text(automation: Automation, data: UnreadFields, key: str) -> str:
    node = data.left.get(key)
    if node is None or node.tag or not isinstance(node.value, str):
        return data.text(key, "")
    data.take(key)
    return templates_of(automation).message(node.value)
