"""The table of alerts, for the doctor, the page and notifications. Pure."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Final, NamedTuple, TypeAlias, get_args

from homebot.config import Language, Urgency
from homebot.devices.device import Device, DevicePart, State, target_of
from homebot.devices.device_types import spoken_type
from homebot.devices.findings import MAX_SHOWN, DeviceCheck, Finding, FindingKind, ShownUrgency
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import PartFacets, compares, fits
from homebot.devices.query.terms import And, GatewayIs, Not, Query, StateIs, leaves
from homebot.devices.wording.time_format import age, age_text
from homebot.devices.words import matching_words
from homebot.words.queries import parse_query

LANGUAGES: Final = get_args(Language)
"""English, and the columns of the table of the others."""


_DAY: Final = 86_400.0


class AlertKind(NamedTuple):
    """A row of the table: its key in ``[alerts]``, its finding, the query for it, and what is said of the devices.

    Attributes:
        over: What is said when it is over.
        told_after: Seconds after which people are told; a door that is open for less is not even shown.
        held: The query that fits as long as what once began lasts, if that is longer than *text* fits.
    """

    key: str
    finding: FindingKind
    text: str
    words: str
    over: str
    told_after: float = 0.0
    urgency: Urgency = "normal"
    held: str = ""

    @property
    def shown_urgency(self) -> ShownUrgency:
        """Its urgency for screens: a kind of which people are told a day later can wait."""
        if self.urgency == "high":
            return "danger"
        return "later" if self.urgency == "low" or self.told_after >= _DAY else "attention"

    def query(self, lost: Iterable[str] = ()) -> Query:
        """Return the query; devices of *lost* gateways are unreachable, as these' own alert says."""
        known = lost if self.finding is FindingKind.UNREACHABLE else ()
        return And((_parse(self.text), *(Not(GatewayIs(name)) for name in known)))


_DETECTS_FIRE = "type=smoke_co_alarm"  # other devices tell that they, or things that they heat, are hot
_PROBLEMS = (
    f"problem=true or safety=true or freeze=true or (heat=true and not {_DETECTS_FIRE})"
    " or lock=jammed or vacuum=error or mower=error"
)
_CHARGED = "not (vacuum or mower or robot or tracker)"  # every day
_WEAK, _NOT_NEW = f"low battery and {_CHARGED}", f"(low battery or battery below 30) and {_CHARGED}"
GATEWAY: Final = AlertKind("gateway", FindingKind.GATEWAY, "", "is away", "is back", 120.0)
ALERTS: Final = (
    AlertKind(
        "smoke",
        FindingKind.SMOKE,
        f"smoke=true or (heat=true and {_DETECTS_FIRE})",
        "reports smoke or heat",
        "no longer reports smoke or heat",
        urgency="high",
    ),
    AlertKind(
        "co",
        FindingKind.CO,
        "carbon_monoxide_alarm=true",
        "reports carbon monoxide",
        "no longer reports carbon monoxide",
        urgency="high",
    ),
    AlertKind("gas", FindingKind.GAS, "gas=true", "reports gas", "no longer reports gas", urgency="high"),
    AlertKind("leak", FindingKind.LEAK, "water_leak=true", "is wet", "is dry again", urgency="high"),
    AlertKind("alarm", FindingKind.ALARM, "alarm=triggered", "is triggered", "is no longer triggered", urgency="high"),
    AlertKind("tamper", FindingKind.TAMPER, "tamper=true", "reports tampering", "no longer reports tampering", 60.0),
    AlertKind("problem", FindingKind.PROBLEM, _PROBLEMS, "reports a problem", "no longer reports a problem", 300.0),
    AlertKind("door", FindingKind.DOOR, "open door", "is open", "is closed again", 900.0),
    AlertKind(
        "unreachable",
        FindingKind.UNREACHABLE,
        "offline and not stale",
        "is unreachable",
        "is reachable again",
        86_400.0,
    ),
    AlertKind("silent", FindingKind.STALE, "stale", "is silent", "reports again", 7 * 86_400.0),
    AlertKind(
        "battery",
        FindingKind.BATTERY,
        _WEAK,
        "has a weak battery",
        "has a good battery again",
        86_400.0,
        "low",
        _NOT_NEW,
    ),
)
"""Every kind of alert about devices."""

_KINDS: Final = {kind.key: kind for kind in (*ALERTS, GATEWAY)}

_DOOR_TAGS = frozenset({"door", "garage", "garage_door", "gate"})


class Alert(NamedTuple):
    """Something wrong with *target*: a device or a part by id, or a gateway; times in seconds since the Unix epoch.

    Attributes:
        name: For people.
        said: What else people are told: texts of the table, with their values.
        why: The reason, for the owner alone: it may contain ids and addresses.
    """

    kind: AlertKind
    target: str
    name: str
    since: float
    said: tuple[tuple[str, str], ...] = ()
    why: str = ""

    @property
    def key(self) -> str:
        """Its cause, which people are told once."""
        return f"{self.kind.key} {self.target}"

    @property
    def detail(self) -> str:
        """The rest of what the owner is shown."""
        return self._details("en") + self.why

    @property
    def text(self) -> str:
        """The alert for the owner."""
        return f"{self.name} {self.kind.words}{self.detail}"

    def told(self, language: Language) -> str:
        """Return the alert for people."""
        return say(f"{{name}} {self.kind.words}", language, name=self._name(language)) + self._details(language)

    def over(self, language: Language) -> str:
        """Return what people are told when it is over."""
        return say(f"{{name}} {self.kind.over}", language, name=self._name(language))

    def _name(self, language: Language) -> str:
        return say("gateway {name}", language, name=self.target) if self.kind is GATEWAY else self.name

    def _details(self, language: Language) -> str:
        return "".join(say(text, language, **{_FIELD.findall(text + "{_}")[0]: value}) for text, value in self.said)

    def is_shown(self, now: float) -> bool:
        """Return whether it has lasted long enough to be shown."""
        return self.kind.key != "door" or now - self.since >= self.kind.told_after


_FIELD: Final = re.compile(r"\{(\w+)\}")


def say(text: str, language: Language, **values: str) -> str:
    """Return the English *text* in *language*, with *values* for its {names}."""
    own = text if language == "en" else _translations()[text][LANGUAGES.index(language) - 1]
    return _FIELD.sub(lambda field: values.get(field[1], field[0]), own)


@cache
def _translations() -> Mapping[str, list[str]]:
    texts: dict[str, list[str]] = json.loads(Path(__file__).with_name("alert_texts.json").read_text(encoding="utf-8"))
    return texts


@cache
def _parse(text: str) -> Query:
    return parse_query(text)


@cache
def _terms(text: str) -> tuple[StateIs, ...]:
    """Return the values that the query *text* is about; none if it is about a whole device."""
    return tuple(term for term in leaves(_parse(text)) if isinstance(term, StateIs))


WATCHED: Final = frozenset(term.capability for kind in ALERTS for term in _terms(kind.text))
"""The capabilities of which a new value may begin or end an alert."""

_HELD: Final = tuple((kind, kind.query()) for kind in (one._replace(text=one.held) for one in ALERTS if one.held))

Asked: TypeAlias = tuple[tuple[AlertKind, Query], ...]
"""Kinds, each with its query."""


def fitting(asked: Asked, device: Device) -> Asked:
    """Return those that *device* fits."""
    facets = facets_of(device)
    return tuple((kind, query) for kind, query in asked if fits(query, facets))


def alerts_of(fitting: Asked, device: Device, now: float) -> Iterator[Alert]:
    """Yield the alerts of kinds that *device* fits: one for each part with a value that fits, else one."""
    for kind, query in fitting:
        if _terms(kind.text):
            yield from _alerts_of_parts(kind, query, device, now)
        else:
            yield _alert_of_device(kind, device, now)


def held_alerts_of(device: Device, now: float) -> Iterator[Alert]:
    """Yield the alerts that *device* would have if they had begun before."""
    yield from alerts_of(fitting(_HELD, device), device, now)


def _alerts_of_parts(kind: AlertKind, query: Query, device: Device, now: float) -> Iterator[Alert]:
    parts = [part for part in device.parts if fits(query, PartFacets(device, part))]
    for part in parts:
        name = _name_of(device) if len(parts) == 1 else f"{_name_of(device)} {part.part.name}".strip()
        if kind.key != "door" or _is_door(device, part):
            yield _alert_of_part(kind, device, part.id, name, now)


def _alert_of_device(kind: AlertKind, device: Device, now: float) -> Alert:
    name = _name_of(device)
    if kind.finding is FindingKind.STALE:
        said = ((", last seen {age} ago", age(device.last_seen, now)),)
        return Alert(kind, device.id, name, device.expires.to_seconds(), said)
    reach = device.reachable
    return Alert(kind, device.id, name, reach.since.to_seconds(), why=f": {reach.why}")


_INTERNAL: Final = re.compile(r"0[xX][0-9a-fA-F]{6,}|[0-9a-fA-F]{12,}|[0-9a-fA-F]{2}([:-][0-9a-fA-F]{2}){5,}|\w+:0x\w+")


def _name_of(device: Device) -> str:
    """Return the name of *device* for people; its room, or else its type, if it has only addresses for names."""
    names = (name for name in device.names or (device.name,) if not _INTERNAL.fullmatch(name))
    return next(names, device.area or spoken_type(device.service_type))


def _alert_of_part(kind: AlertKind, device: Device, part_id: str, name: str, now: float) -> Alert:
    states = [state for term, state in _values(kind, device, part_id) if compares(term, state.value.plain())]
    since = max(state.since.to_seconds() for state in states)
    return Alert(kind, target_of(device.id, part_id), name, since, (*_details(device, states, since, now),))


def kind_of(key: str) -> AlertKind:
    """Return the kind of the cause *key*."""
    return _KINDS[key.partition(" ")[0]]


def is_over(key: str, device: Device) -> bool:
    """Return whether the cause *key* is known to be over, as *device* has no such alert: silence does not prove it."""
    kind = kind_of(key)
    if _terms(kind.text):
        return bool(_values(kind, device, key.partition("#")[2]))
    return device.freshness == "fresh" and device.reachable.state != "no"


def doctor_checks(lost: Iterable[str]) -> Iterator[DeviceCheck]:
    """Yield the check of each kind but gateways; that devices of *lost* ones are unreachable is no finding."""
    for kind in ALERTS:
        query = kind.query(lost)
        yield DeviceCheck(kind.finding, kind.text, partial(_show, kind, query), asked=query)


def _show(kind: AlertKind, query: Query, device: Device, now: float) -> Iterable[str]:
    alerts = alerts_of(fitting(((kind, query),), device), device, now)
    return (_why(alert) for alert in alerts if alert.is_shown(now))


def _why(alert: Alert) -> str:
    return f"{alert.kind.words}{alert.detail}" if _terms(alert.kind.text) else alert.detail.lstrip(",: ")


def findings_of(alerts: Iterable[Alert]) -> tuple[Finding, ...]:
    """Return *alerts* as findings, the worst first."""
    rows: dict[FindingKind, list[tuple[str, str]]] = {kind: [] for kind in FindingKind}
    urgencies: dict[FindingKind, ShownUrgency] = {}
    for alert in alerts:
        is_gateway = alert.kind is GATEWAY
        row = ("", alert.text) if is_gateway else (alert.target.partition("#")[0], _why(alert))
        rows[alert.kind.finding].append(row)
        urgencies[alert.kind.finding] = alert.kind.shown_urgency
    return tuple(
        kind.finding(some[:MAX_SHOWN], total=len(some)).model_copy(update={"urgency": urgencies[kind]})
        for kind, some in rows.items()
        if some
    )


def _values(kind: AlertKind, device: Device, part_id: str) -> list[tuple[StateIs, State]]:
    """Return the known values of a part that decide on *kind*, each with its term."""
    known = [state for state in device.states if state.part == part_id and state.value.plain() is not None]
    return [(term, state) for term in _terms(kind.text) for state in known if state.capability == term.capability]


def _is_door(device: Device, part: DevicePart) -> bool:
    """Return whether it is a door by its kind, or by its name if it declares none: an open window is no alert."""
    is_declared = part.part.tag in _DOOR_TAGS or part.part.service_type == "closure"
    return is_declared or bool(matching_words(f"{device.name} {part.part.name}", frozenset({"entry"})))


def _details(device: Device, states: list[State], since: float, now: float) -> Iterator[tuple[str, str]]:
    """Yield the charge of a battery, and why the values may be out of date, or for how long they have lasted."""
    if states[0].capability == "battery":
        yield " ({charge} %)", f"{states[0].value.number:.0f}"
    if device.reachable.state == "no":
        yield ", by an old report: it is unreachable now", ""
    elif device.freshness == "stale":
        yield ", by an old report: last seen {age} ago", age(device.last_seen, now)
    elif not any(state.live for state in states):
        yield ", by a kept report: it has not reported itself yet", ""
    elif now - since >= 60.0 and states[0].capability != "battery":
        yield ", for {age}", age_text(now - since)
