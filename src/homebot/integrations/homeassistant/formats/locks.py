"""Door locks and alarms, which may need a code for commands. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt``: alarm_control_panel.py and lock.py; Zigbee2MQTT 1.42,
``lib/extension/homeassistant.ts``.
"""

from hmac import compare_digest

from homebot.conventions.command_values import require_option
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.entity_rows import ALARM_ACTIONS, ALARM_STATES, code_of
from homebot.conventions.payload import Readings, shown, unreadable
from homebot.devices.value import PlainValue
from homebot.errors import WrongCodeError
from homebot.integrations.homeassistant.formats.components import LOCK_STATES
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.entity import Entity
from homebot.integrations.homeassistant.formats.topics import CommandTopic
from homebot.support.folding import words_of

_KEY_LOCKS = frozenset({("child", "lock"), ("keypad", "lock")})
"""The last words of ids and names of locks of keys, not of doors, as those of Zigbee2MQTT."""

_REMOTE_CODES = frozenset({"REMOTE_CODE", "REMOTE_CODE_TEXT"})


def build_lock(config: DiscoveryConfig) -> DescribedPart:
    """Describe a door lock, or a setting if it only locks the keys of a device.

    A door lock that needs a code is commanded with one, and checks it itself. The config's ``code_format`` is never
    run: it is a foreign regular expression.
    """
    command = config.required_command()
    if any(words_of(text)[-2:] in _KEY_LOCKS for text in (config.discovery_id, config.text("name"))):
        return _build_key_lock(config, command)
    # Of two states with the same payload the later one counts.
    states: dict[str, str | None] = {config.text(f"state_{state}", state.upper()): state for state in LOCK_STATES}
    states[config.text("payload_reset", "None")] = None
    payloads = {"locked": config.text("payload_lock", "LOCK"), "unlocked": config.text("payload_unlock", "UNLOCK")}
    if config.has("payload_open"):
        payloads["open"] = config.text("payload_open")
    code_format = code_of(config.text("code_format"))

    def read(text: str) -> Readings:
        return {"lock": states[text]} if text.strip() and text in states else unreadable(text, states)

    def write(value: PlainValue, code: str) -> Publications:
        if code_format and not code:
            raise WrongCodeError.missing(f"lock {shown(value)}")
        return (command.publication_with_code(payloads[require_option("lock", value, payloads)], code),)

    entity = Entity(config, "door_lock")
    readable = entity.read_text_from(config.source("state_topic"), read)
    sends_code = command.template is not None
    entity.add_coded_capability("lock", write, sends_code=sends_code, readable=readable, code=code_format)
    entity.add_commands(command)
    return entity.build()


def _build_key_lock(config: DiscoveryConfig, command: CommandTopic) -> DescribedPart:
    payloads = {True: config.text("payload_lock", "LOCK"), False: config.text("payload_unlock", "UNLOCK")}
    states: dict[str, bool | None] = {
        config.text("state_unlocked") or payloads[False]: False,
        config.text("state_locked") or payloads[True]: True,
        config.text("payload_reset", "None"): None,
    }
    values = {"entity_category": "config", **config.values}
    entity = Entity(DiscoveryConfig(config.component, config.discovery_id, values), "x_setting")
    entity.add_flag("on_off", config.source("state_topic"), command, payloads, states)
    return entity.build()


def build_alarm_control_panel(config: DiscoveryConfig) -> DescribedPart:
    """Describe an alarm. homebot compares the code if the config names one; ``REMOTE_CODE`` is checked by the alarm."""
    source = config.required_source("state_topic")
    actions = {state: action for state, (_, action) in ALARM_ACTIONS.items()}
    if config.has("supported_features"):
        features = {"disarm", *config.options("supported_features")}
        actions = {state: action for state, action in actions.items() if action in features}
    command = config.required_command()
    payloads = {state: config.text(f"payload_{action}", action.upper()) for state, action in actions.items()}
    known_code = config.text("code")
    is_coded = {
        state: config.has("code") and config.flag(f"code_{action.partition('_')[0]}_required", default=True)
        for state, action in actions.items()
    }

    def read(text: str) -> Readings:
        if text == "None":
            return {"alarm": None}
        return {"alarm": text} if text in ALARM_STATES else unreadable(text, ALARM_STATES)

    def write(value: PlainValue, code: str) -> Publications:
        state = require_option("alarm", value, payloads)
        if is_coded[state]:
            if not code:
                raise WrongCodeError.missing(f"alarm {state}")
            if known_code not in _REMOTE_CODES and not compare_digest(code.encode(), known_code.encode()):
                raise WrongCodeError(f"alarm {state}", "the code is wrong")
        action = payloads[state]
        payload = action if command.template is None else None
        return (command.publication_with_code(payload, code, {"action": action}),)

    entity = Entity(config, "x_alarm_panel")
    readable = entity.read_text_from(source, read)
    sends_code = command.template is not None
    is_of_digits = known_code == "REMOTE_CODE" or known_code.isdecimal()
    entity.add_coded_capability(
        "alarm",
        write,
        sends_code=sends_code,
        readable=readable,
        options=ALARM_STATES,
        code=("digits" if is_of_digits else "text") if any(is_coded.values()) else "",
    )
    entity.add_commands(command)
    return entity.build()
