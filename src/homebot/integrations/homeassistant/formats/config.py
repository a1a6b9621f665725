"""The config of one component, with its fields read in the types they should have. Pure.

Every field is read as in Home Assistant: a JSON number or boolean in place of a text becomes the text of Python, so
that ``"payload_on": false`` is ``False``.

Source: Home Assistant core 2025.4, ``helpers/config_validation.py`` and ``components/mqtt/schemas.py``.
"""

import math
from collections.abc import Callable, Mapping
from functools import lru_cache

from homebot.conventions.payload import clean_text, shown
from homebot.conventions.secrets import names_secret
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.jinja import Template, compile_template
from homebot.integrations.homeassistant.formats.topics import CommandTopic, ValueSource, valid_topic
from homebot.mqtt.topics import validate_filter, validate_topic

MAX_OPTIONS = 2_000
"""Most entries of a list in a config, such as the effects of a lamp."""

_MAX_TEXT = 8 * 1024
_MAX_OPTION = 255
_MAX_ID = 255
_TELLS_TEXTS = frozenset({"number", "sensor", "text"})
_HAS_MEANING = frozenset({"device_class", "state_class", "unit_of_measurement"})


def full_keys(fields: dict[str, object], table: Mapping[str, str]) -> dict[str, object]:
    """Return *fields* with the full keys of *table*; of both forms of a key the short one wins."""
    if table.keys().isdisjoint(fields):
        return fields
    full = dict(fields)
    for key in fields:
        if key in table:
            full[table[key]] = full.pop(key)
    return full


class DiscoveryConfig:
    """One component of an announcement, in full keys.

    Every getter raises a :class:`WireError` with field and value for an invalid field; Home Assistant refuses such a
    component as well. JSON ``null`` means a missing field.

    Attributes:
        discovery_id: Its id in the announcement; the id of the part without a ``unique_id``.
        encoding: The encoding of its texts; empty for binary payloads. UTF-8 also for an unknown one.
    """

    __slots__ = ("component", "discovery_id", "encoding", "qos", "retain", "values")

    def __init__(self, component: str, discovery_id: str, values: Mapping[str, object]) -> None:
        self.component = component
        self.discovery_id = discovery_id
        self.values = values
        self.qos, self.retain, self.encoding = 0, False, "utf-8"
        if not _TRANSPORT.isdisjoint(values):
            self.qos = self.integer("qos", 0, least=0, most=2)
            self.retain = self.flag("retain")
            encoding = self.text("encoding", "utf-8").lower()
            self.encoding = _CODECS.get(encoding, "utf-8")

    @property
    def is_secret(self) -> bool:
        """True if it reports a code or password, by its name, or else its id, or by its template.

        An id often has the name of the device, such as a keypad for PIN codes; values with a unit or class are no
        codes.
        """
        if self.component not in _TELLS_TEXTS or not _HAS_MEANING.isdisjoint(self.values):
            return False
        named = self.text("name") or self.text("unique_id") or self.discovery_id
        return _names_secret(named) or _names_secret(self.text("value_template"))

    @property
    def device_class(self) -> str:
        """Its ``device_class``, in small letters as Home Assistant reads each; empty for none."""
        return self.clean_text("device_class").lower()

    @property
    def part_id(self) -> str:
        """The id of its part: its ``unique_id``, or else its id in the announcement."""
        return clean_text(self.text("unique_id") or self.discovery_id, _MAX_ID)

    def of_commands(self) -> list[tuple[str, object]]:
        """Return the fields that may determine the payloads of commands, sorted; no code's value.

        Topics are left out, but for which of them are equal: the part has each once.
        """
        keys = sorted(filter(_is_of_commands, self.values))
        values = {**self.values, "code": self.has("code")} if "code" in self.values else self.values
        pairs = list(zip(keys, map(values.__getitem__, keys), strict=True))
        kinds = sorted(filter(_is_command_topic, self.values))
        topics = list(map(str, map(self.values.get, kinds)))
        if len(set(topics)) < len(topics):
            pairs.append(("topics", list(zip(kinds, map(topics.index, topics), strict=True))))
        return pairs

    def has(self, key: str) -> bool:
        """Return whether the field exists and is not null."""
        return self.values.get(key) is not None

    def text(self, key: str, default: str = "") -> str:
        """Return a text, at most 8 kB long; a number or boolean as Python spells it."""
        value = self.values.get(key)
        if value is None:
            return default
        return value if isinstance(value, str) and len(value) <= _MAX_TEXT else self._as_text(key, value)

    def clean_text(self, key: str, limit: int = 120) -> str:
        """Return a text for output; empty for none."""
        text = self.text(key)
        return clean_text(text, limit) if text else ""

    def payload(self, key: str, default: str) -> str | None:
        """Return the payload of a command; None if the config removes it by null."""
        return None if self.values.get(key, default) is None else self.text(key, default)

    def flag(self, key: str, default: bool = False) -> bool:  # noqa: FBT001, FBT002 - reads like a mapping's get
        """Return a boolean; also ``yes``, ``on``, ``1`` and the like."""
        value = self.values.get(key)
        match value:
            case None:
                return default
            case bool():
                return value
            case int() | float():
                return value != 0
            case str() if (text := value.strip().lower()) in _FLAGS:
                return _FLAGS[text]
            case _:
                raise self._refusal(key, value, "true or false")

    def number(self, key: str, default: float) -> float:
        """Return a finite number."""
        value = self.values.get(key)
        try:
            number = default if value is None else float(value) if isinstance(value, (str, int, float)) else math.nan
        except (ValueError, OverflowError):
            number = math.nan
        if not math.isfinite(number):
            raise self._refusal(key, value, "a number")
        return number

    def seconds(self, key: str) -> float | None:
        """Return a time; None if it is missing or longer than ten years, which means for ever."""
        seconds = self.integer(key, _FOR_EVER, least=0)
        return float(seconds) if seconds < _FOR_EVER else None

    def integer(self, key: str, default: int, *, least: int = -(2**53), most: int = 2**53) -> int:
        """Return a whole number within the bounds; a fraction is cut off."""
        value = self.values.get(key)
        if value is None:
            return default
        try:
            whole = int(value) if isinstance(value, (str, int, float)) and len(str(value)) <= _MAX_DIGITS else None
        except (ValueError, OverflowError):
            whole = None
        if whole is None or not least <= whole <= most:
            raise self._refusal(key, value, f"a whole number from {least} to {most}")
        return whole

    def options(self, key: str) -> tuple[str, ...]:
        """Return a list of texts, each at most 255 long; a single text is a list of one. Empty for none."""
        value = self.values.get(key)
        if value is None:
            return ()
        entries = value if isinstance(value, list) else [value]
        if len(entries) > MAX_OPTIONS:
            raise self._refusal(key, value, f"a list of at most {MAX_OPTIONS} texts")
        options = tuple([entry if isinstance(entry, str) else self._as_text(key, entry) for entry in entries])
        longest = max(options, key=len, default="")
        if len(longest) > _MAX_OPTION:
            raise self._refusal(key, longest, f"texts of at most {_MAX_OPTION} characters")
        return options

    def on_off_payloads(self) -> dict[bool, str]:
        """Return the payloads of on and off."""
        return {True: self.text("payload_on", "ON"), False: self.text("payload_off", "OFF")}

    def on_off_states(self) -> dict[str, bool | None]:
        """Return the reported texts of on, off and unknown; the payloads if the config names none."""
        payloads = self.on_off_payloads()
        on, off = (self.text(f"state_{name}") or payloads[is_on] for name, is_on in (("on", True), ("off", False)))
        return {on: True, off: False, "None": None}

    def template(self, key: str) -> Template | None:
        """Return a template, or None; its ``problem`` tells whether it can be used."""
        return None if self.values.get(key) is None else compile_template(self.text(key))

    def state_topic(self, key: str = "state_topic") -> str:
        """Return a topic to subscribe to, perhaps with wildcards; empty for none."""
        return "" if self.values.get(key) is None else self._topic(key, validate_filter)

    def source(
        self, topic_key: str, template_key: str = "value_template", variables: Mapping[str, object] | None = None
    ) -> ValueSource | None:
        """Return topic and template of a reported value, with further variables; None without a topic."""
        topic = self.state_topic(topic_key)
        return ValueSource(topic, self.template(template_key), self.encoding, variables) if topic else None

    def required_source(self, topic_key: str) -> ValueSource:
        """Return a source as :meth:`source`; the topic is required."""
        source = self.source(topic_key)
        if source is None:
            raise self._refusal(topic_key, None, "a topic")
        return source

    def command(self, topic_key: str, template_key: str = "command_template") -> CommandTopic | None:
        """Return topic and template of a command, of which *template_key* may be empty; None without a topic."""
        if self.values.get(topic_key) is None:
            return None
        template = self.template(template_key) if template_key else None
        topic = self._topic(topic_key, validate_topic)
        return CommandTopic(topic, template, self.qos, self.retain, self.encoding)

    def required_command(
        self, topic_key: str = "command_topic", template_key: str = "command_template"
    ) -> CommandTopic:
        """Return a command as :meth:`command`; the topic is required."""
        command = self.command(topic_key, template_key)
        if command is None:
            raise self._refusal(topic_key, None, "a topic")
        return command

    def value_source(self, name: str) -> ValueSource | None:
        """Return the source in the fields ``<name>_state_topic`` and ``<name>_value_template``."""
        return self.source(f"{name}_state_topic", f"{name}_value_template")

    def command_of(self, name: str) -> CommandTopic | None:
        """Return the command in the fields ``<name>_command_topic`` and ``<name>_command_template``."""
        return self.command(f"{name}_command_topic", f"{name}_command_template")

    def _topic(self, key: str, validate: Callable[[str], object]) -> str:
        return valid_topic(f"{self.component}: {key}", self.text(key), validate)

    def _as_text(self, key: str, value: object) -> str:
        """Return the text that Python makes of *value*, which is none, or one that is too long."""
        if isinstance(value, str):
            raise self._refusal(key, value, f"a text of at most {_MAX_TEXT} characters")
        if isinstance(value, (bool, float)) or (isinstance(value, int) and -_HUGE < value < _HUGE):
            return str(value)
        raise self._refusal(key, value, "a text")

    def _refusal(self, key: str, value: object, expected: str) -> WireError:
        return WireError(f"{self.component}: {key} is {shown(value)}, not {expected}")


_names_secret = lru_cache(maxsize=512)(names_secret)  # devices share names and templates
_TRANSPORT = frozenset({"encoding", "qos", "retain"})
_CODECS = {
    "": "",
    **dict.fromkeys(("ascii", "us-ascii"), "ascii"),
    **dict.fromkeys(("latin-1", "latin1", "iso-8859-1"), "latin-1"),
    **dict.fromkeys(("cp1252", "windows-1252"), "cp1252"),
}
_SHOWN = frozenset(
    {
        *("availability", "availability_mode", "default_entity_id", "device", "device_class"),
        *("enabled_by_default", "entity_category", "entity_picture", "expire_after", "force_update", "icon", "name"),
        *("object_id", "origin", "payload_available", "payload_not_available", "payload_reset", "platform"),
        *("suggested_display_precision", "unique_id"),
    }
)
"""Fields of presentation and reports: no command depends on them."""


@lru_cache(maxsize=1024)
def _is_of_commands(key: str) -> bool:
    if key.endswith("template"):
        return "command" in key or key == "set_position_template"
    return key not in _SHOWN and not key.startswith("state_") and not key.endswith("_topic")


@lru_cache(maxsize=256)
def _is_command_topic(key: str) -> bool:
    return key.endswith("command_topic") or key == "set_position_topic"


_HUGE = 10**30
_FOR_EVER = 10 * 366 * 86_400
_MAX_DIGITS = 40
_FLAGS = dict.fromkeys(("1", "true", "yes", "on", "enable"), True) | dict.fromkeys(
    ("0", "false", "no", "off", "disable"), False
)
