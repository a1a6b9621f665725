"""An entity of Home Assistant as a part: its readings, and the service calls of its commands. Pure.

Source: Home Assistant core 2024.3, ``helpers/entity.py`` and ``const.py``.
"""

from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from types import MappingProxyType
from typing import Final, NamedTuple

from homebot.conventions.capability_row import described, writer_of
from homebot.conventions.command_values import require_transition
from homebot.conventions.entity_rows import EntityRow, Fields, options_of, tag_of, text_of
from homebot.conventions.payload import Readings
from homebot.conventions.secrets import names_secret
from homebot.devices.capabilities import EVENTS
from homebot.devices.part import Part, payload_digest
from homebot.devices.value import PlainValue, SetBy
from homebot.devices.words import ALL_THAT_ASK, matching_words
from homebot.integrations.homeassistant.formats.states.domains import DOMAINS
from homebot.integrations.homeassistant.formats.states.registries import EntityEntry, Registries
from homebot.integrations.homeassistant.formats.states.rows import has

_UNAVAILABLE, _UNKNOWN = "unavailable", "unknown"
_MAX_TRANSITION_S: Final = 6_553.0
"""Longest transition of ``light.turn_on`` and ``scene.turn_on``."""


_JUST_NOW: Final = 5.0
"""Seconds between an event and its state, both by Home Assistant's clock; a restored event is older."""

_SHAPING: Final = frozenset(
    {
        *("assumed_state", "available_modes", "available_tones", "code_arm_required", "code_format", "device_class"),
        "device_trackers",
        *(
            "entity_id",
            "effect_list",
            "event_types",
            "fan_modes",
            "fan_speed_list",
            "friendly_name",
            "hvac_modes",
            "max",
        ),
        *("max_color_temp_kelvin", "max_humidity", "max_temp", "maximum", "min", "min_color_temp_kelvin"),
        *("min_humidity", "min_temp", "minimum", "mode", "operation_list", "options", "percentage_step"),
        *("preset_modes", "source_list", "state_class", "step", "supported_color_modes", "supported_features"),
        *("swing_horizontal_modes", "swing_modes", "target_humidity_step", "target_temp_step", "unit_of_measurement"),
    }
)
"""Attributes on which the capabilities of an entity depend."""


class ServiceCall(NamedTuple):
    """A call of a service for one entity."""

    domain: str
    service: str
    entity_id: str
    data: Fields


class HomeAssistantEntity:
    """An entity with a state.

    Args:
        entity_id: Its present id, which a person may change.
        entry: Its entry in the registry.
        celsius: Whether Home Assistant counts in °C, otherwise in °F.
        others: All entities by id, of which any may be a group in a group.

    Attributes:
        domain: Its domain: ``light``.
        info: Its last known attributes, and its state as ``state``.
        has_state: Whether Home Assistant shows it now; not while it is reloaded.
        is_available: Whether it can be reached; ``unknown`` is a state of one that can.
        device_key: The key of its device; empty for one that is left out, None before the first grouping.
    """

    def __init__(
        self,
        entity_id: str,
        entry: EntityEntry,
        *,
        celsius: bool = True,
        others: Mapping[str, "HomeAssistantEntity"] = MappingProxyType({}),
    ) -> None:
        self.entity_id = entity_id
        self._others = others
        self.entry = entry
        self.domain = entity_id.partition(".")[0]
        self.has_state = self.is_available = False
        self.device_key: str | None = None
        self.info: dict[str, object] = {"is_fahrenheit": not celsius}
        self._changed_at = 0.0
        self._context: dict[str, object] = {}
        self._taken: Fields = {}
        self._rows: dict[str, EntityRow] = {}

    def is_left_out(self, registries: Registries) -> bool:
        """Return whether homebot does not use it: no type of its domain, a secret, a scene that could hurt, a group.

        A group of lights, switches or covers with a list of these is used.
        """
        kind = DOMAINS.get(self.domain)
        if kind is None or self.entry.is_disabled or (self.domain == "sensor" and names_secret(self.name)):
            return True
        if self.domain == "scene":
            return any(map(_may_hurt, self.members))
        is_set = any(row.write for row in kind.rows) and self.is_group
        return is_set and not self._is_whole(registries) and not self.reaches_others(registries)

    def reaches_others(self, registries: Registries) -> bool:
        """Return whether it is a way to reach lights, switches or covers of other devices, none of which may hurt."""
        named = [member.partition(".") for member in self.members]
        is_used = self.domain in _GROUPED and bool(named) and {domain for domain, _, _ in named} <= _GROUPED
        can_hurt = any(domain != "light" and matching_words(name, ALL_THAT_ASK) for domain, _, name in named)
        return is_used and not can_hurt and not self._is_whole(registries)

    def _is_whole(self, registries: Registries) -> bool:
        """Return whether it stands for its own device, as WLED's main light, without which all segments are dark."""
        return {registries.entity(member).device_id for member in self.members} == {self.entry.device_id or None}

    @property
    def is_group(self) -> bool:
        """True if it stands for others."""
        return bool(self._listed) or any(self.info.get(mark) is True for mark in _GROUP_MARKS)

    @property
    def members(self) -> Sequence[str]:
        """The entities that it sets, with the members of a group in its place."""
        members, groups = list[str](), {self.entity_id}
        waiting = [*reversed(self._listed)]
        while waiting:
            entity_id = waiting.pop()
            inner = self._others[entity_id]._listed if entity_id in self._others else ()  # noqa: SLF001 - of the same class
            if entity_id not in groups and not inner:
                members.append(entity_id)
            elif entity_id not in groups:
                groups.add(entity_id)
                waiting += reversed(inner)
        return tuple(dict.fromkeys(members))

    @property
    def _listed(self) -> Sequence[str]:
        fields = ("entity_id", "group_entities", "device_trackers")
        return next((options for field in fields if (options := options_of(self.info, field))), ())

    @property
    def name(self) -> str:
        """Its name without that of its device; empty for none."""
        return self.entry.name or ("" if self.entry.device_id else text_of(self.info, "friendly_name"))

    def put(self, change: Mapping[str, object], *, is_new: bool) -> bool:
        """Apply a compressed state, or the difference to the last one, and return whether its part may be another.

        Args:
            change: ``s`` for the state, ``a`` for attributes, ``lc`` for the time of the last change, ``c`` for the
                context: its id alone if it has neither user nor parent, or if only its id is another one.
            is_new: Whether it is a whole state.
        """
        state, attributes, self._taken = change.get("s"), change.get("a"), {}
        info = attributes if isinstance(attributes, dict) else {}
        before = {key: self.info.get(key) for key in info if key in _SHAPING or key not in self.info}
        if is_new:
            for key in self.info.keys() - info.keys() - _SHAPING - {"is_fahrenheit"}:
                self.info[key] = None
        self.info.update(info)
        if isinstance(state, str):
            self.info["state"] = state
            self.has_state = True
            self.is_available = state != _UNAVAILABLE
        context = change.get("c")
        if is_new:
            self._context = {}
        if isinstance(context, dict):
            self._context |= context
        changed_at = change.get("lc")
        self._changed_at = float(changed_at) if isinstance(changed_at, (int, float)) else self._changed_at
        return is_new or any(self.info[key] != old for key, old in before.items())

    def set_by(self, own_user: str) -> SetBy:
        """Return who brought about the last state, by its context: a user, or an automation or script.

        Args:
            own_user: The id of homebot's own user in Home Assistant.

        Source: Home Assistant 2026.11, ``homeassistant/core.py``, ``Context``.
        """
        user = self._context.get("user_id")
        if user and user != own_user:
            return "person"
        return "program" if self._context.get("parent_id") and not user else ""

    def forget(self, attributes: Iterable[object]) -> None:
        """Apply that it no longer has these *attributes*."""
        for key in attributes:
            if isinstance(key, str) and key in self.info:
                self.info[key] = None

    def part(self) -> Part:
        """Return its part, with the capabilities of its last attributes."""
        kind = DOMAINS[self.domain]
        rows = described(kind.rows, self._known, assumed=self.info.get("assumed_state") is True)
        self._rows = {capability.name: row for capability, row in rows}
        is_set = any(row.write for _, row in rows)
        service_type = kind.service_type if isinstance(kind.service_type, str) else kind.service_type(self.info)
        return Part(
            id=self.entry.part_id,
            name=self.name,
            service_type=service_type,
            advertised="device_tracker" if self.domain == "person" else self.domain,  # people are of the house
            tag=tag_of(self.info, is_set=is_set) if kind.tag is None else kind.tag,
            category=self.entry.category,
            capabilities=tuple(capability for capability, _ in rows),
            payloads=payload_digest((self.entity_id, self.info.get("supported_features"))) if is_set else "",
            fades=self._fades,
        )

    def read(self, *, is_change: bool) -> Readings:
        """Return its values: nothing while it is unavailable, None for unknown ones.

        Attributes are known also in an unknown state, such as the temperature of a thermostat of unknown mode.

        Args:
            is_change: Whether the state is a change that came now; only then is there an event in it.
        """
        if not self.is_available:
            return {}
        shown = {**self.info, "state": None} if self.info.get("state") == _UNKNOWN else self.info
        readings = {name: row.read(self.info, shown) for name, row in self._rows.items() if row.read is not None}
        if not EVENTS.isdisjoint(readings) and not (is_change and self._is_of_now()):
            return {}
        return {name: value for name, value in readings.items() if value is not None or name not in EVENTS}

    def call(self, capability: str, value: PlainValue, transition: float = 0.0, code: str = "") -> ServiceCall:
        """Return the call that sets *capability*.

        Raises:
            RefusedError: It is not settable, or needs a code, or the value is invalid; names the valid ones.
        """
        info = {**self._known, **self._taken}
        data = dict(writer_of(self._rows.values(), capability)(info, value, code))
        service = str(data.pop("service"))
        if transition and self._fades:
            data["transition"] = require_transition(transition, _MAX_TRANSITION_S)
        return ServiceCall(self.domain, service, self.entity_id, data)

    @property
    def _known(self) -> Fields:
        """Its attributes, without the format of a code that Home Assistant knows."""
        return {**self.info, "code_format": None} if self.entry.has_code else self.info

    @property
    def _fades(self) -> bool:
        """True if its service takes a transition: LightEntityFeature.TRANSITION."""
        return self.domain == "scene" or (self.domain == "light" and bool(has(32)(self.info)))

    def expect(self, call: ServiceCall) -> None:
        """Count with what a thermostat was set to until its state comes: both ends of a pair are set together."""
        if self.domain == "climate":
            attributes = {"state" if key == "hvac_mode" else key: value for key, value in call.data.items()}
            self._taken = {**self._taken, **attributes}

    def _is_of_now(self) -> bool:
        """Return whether the moment of its event, which is its state, is that of the change."""
        try:
            happened_at = datetime.fromisoformat(str(self.info.get("state"))[:40]).timestamp()
        except (ValueError, OverflowError):
            return False
        return abs(happened_at - self._changed_at) < _JUST_NOW


def _may_hurt(member: str) -> bool:
    """Return whether a scene must not move *member* past its own approval."""
    domain, _, name = member.partition(".")
    return domain in _CAN_HURT or (domain == "switch" and bool(matching_words(name, ALL_THAT_ASK)))


_GROUP_MARKS: Final = ("is_hue_group", "is_deconz_group")
"""Attributes of groups without a list of members, which are devices themselves: each with its room and approval."""

_GROUPED: Final = frozenset({"cover", "light", "switch"})
"""Domains of groups that are used, and of their members."""

_CAN_HURT: Final = frozenset(
    {"alarm_control_panel", "climate", "cover", "lawn_mower", "lock", "script", "valve", "water_heater"}
)
"""Domains with devices that a scene must not move past their own approvals."""
