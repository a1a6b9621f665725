"""Alerts: what is wrong in the house, by one table for the doctor, the page and notifications. Pure."""

from collections.abc import Iterable, Iterator
from functools import cache
from typing import Final, NamedTuple

from homebot.devices.device import Device, DevicePart, State, target_of
from homebot.devices.findings import Finding, FindingKind
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import PartFacets, compares, fits
from homebot.devices.query.parse import parse_query
from homebot.devices.query.terms import And, GatewayIs, Not, Query, StateIs, leaves
from homebot.devices.wording.time_format import age_text, ago
from homebot.devices.words import matching_words

__all__ = ["ALERTS", "GATEWAY", "MOST_SHOWN", "WATCHED", "Alert", "AlertKind", "alerts_of", "findings_of", "is_over"]

MOST_SHOWN: Final = 20
"""The limit of rows of a finding."""


class AlertKind(NamedTuple):
    """A row of the table: its key in ``[alerts]``, its finding, the query for it, and what is said of the devices.

    Attributes:
        told_after: Seconds after which people are told; a door that is open for less is not even shown.
    """

    key: str
    finding: FindingKind
    text: str
    words: str
    told_after: float = 0.0

    def query(self, lost: Iterable[str] = ()) -> Query:
        """Return the query; devices of *lost* gateways are unreachable, as these' own alert says."""
        known = lost if self.finding is FindingKind.UNREACHABLE else ()
        return And((_parsed(self.text), *(Not(GatewayIs(name)) for name in known)))


_PROBLEMS = "problem=true or safety=true or freeze=true or lock=jammed or vacuum=error or mower=error"
_WEAK = "low battery and not (vacuum or mower or robot or tracker)"  # these are charged every day
GATEWAY: Final = AlertKind("gateway", FindingKind.GATEWAY, "", "is away", 120.0)
ALERTS: Final = (
    AlertKind("smoke", FindingKind.SMOKE, "smoke=true or heat=true", "reports smoke or heat"),
    AlertKind("co", FindingKind.CO, "carbon_monoxide_alarm=true", "reports carbon monoxide"),
    AlertKind("gas", FindingKind.GAS, "gas=true", "reports gas"),
    AlertKind("leak", FindingKind.LEAK, "water_leak=true", "is wet"),
    AlertKind("alarm", FindingKind.ALARM, "alarm=triggered", "is triggered"),
    AlertKind("tamper", FindingKind.TAMPER, "tamper=true", "reports tampering", 60.0),
    AlertKind("problem", FindingKind.PROBLEM, _PROBLEMS, "reports a problem", 300.0),
    AlertKind("door", FindingKind.DOOR, "open door", "is open", 900.0),
    AlertKind("unreachable", FindingKind.UNREACHABLE, "offline and not stale", "is unreachable", 86_400.0),
    AlertKind("silent", FindingKind.STALE, "stale", "is silent", 7 * 86_400.0),
    AlertKind("battery", FindingKind.BATTERY, _WEAK, "has a weak battery", 86_400.0),
)
"""Every kind of alert about devices."""

_DOOR_TAGS = frozenset({"door", "garage", "garage_door", "gate"})


class Alert(NamedTuple):
    """Something wrong with *target*: a device or a part by id, or a gateway; times in seconds since the Unix epoch."""

    kind: AlertKind
    target: str
    name: str
    since: float
    detail: str

    @property
    def key(self) -> str:
        """Its cause, which people are told once."""
        return f"{self.kind.key} {self.target}"

    @property
    def text(self) -> str:
        """The alert for people."""
        return f"{self.name} {self.kind.words}{self.detail}"

    def is_shown(self, now: float) -> bool:
        """Return whether it has lasted long enough to be shown."""
        return self.kind.key != "door" or now - self.since >= self.kind.told_after


@cache
def _parsed(text: str) -> Query:
    return parse_query(text)


@cache
def _terms(kind: AlertKind) -> tuple[StateIs, ...]:
    """Return the values that *kind* is about; none if it is about a whole device."""
    return tuple(one for one in leaves(_parsed(kind.text)) if isinstance(one, StateIs))


WATCHED: Final = frozenset(term.capability for kind in ALERTS for term in _terms(kind))
"""The capabilities of which a new value may begin or end an alert."""


def alerts_of(kinds: Iterable[AlertKind], device: Device, now: float, lost: Iterable[str] = ()) -> Iterator[Alert]:
    """Yield the alerts of some kinds about *device*: one for each part with a value that fits, else one."""
    facets = facets_of(device)
    for kind in kinds:
        if fits(query := kind.query(lost), facets):
            if _terms(kind):
                yield from _alerts_of_parts(kind, query, device, now)
            else:
                yield _alert_of_device(kind, device, now)


def _alerts_of_parts(kind: AlertKind, query: Query, device: Device, now: float) -> Iterator[Alert]:
    parts = [one for one in device.parts if fits(query, PartFacets(device, one))]
    for part in parts:
        name = device.name if len(parts) == 1 else f"{device.name} {part.part.name or part.id}"
        if kind.key != "door" or _is_door(device, part):
            yield _alert_of_part(kind, device, part.id, name, now)


def _alert_of_device(kind: AlertKind, device: Device, now: float) -> Alert:
    if kind.finding is FindingKind.STALE:
        begin, detail = device.expires, f", last seen {ago(device.last_seen, now)}"
    else:
        begin, detail = device.reachable.since, f": {device.reachable.why}"
    return Alert(kind, device.id, device.name, begin.to_seconds(), detail)


def _alert_of_part(kind: AlertKind, device: Device, part_id: str, name: str, now: float) -> Alert:
    states = [one for term, one in _values(kind, device, part_id) if compares(term, one.value.plain())]
    since = max(one.since.to_seconds() for one in states)
    return Alert(kind, target_of(device.id, part_id), name, since, _detail(device, states, since, now))


def is_over(key: str, device: Device) -> bool:
    """Return whether the cause *key* is known to be over, as *device* has no such alert: silence does not prove it."""
    kind = next(one for one in ALERTS if one.key == key.partition(" ")[0])
    if _terms(kind):
        return bool(_values(kind, device, key.partition("#")[2]))
    return device.freshness == "fresh" and device.reachable.state != "no"


def findings_of(alerts: Iterable[Alert]) -> tuple[Finding, ...]:
    """Return *alerts* as findings, the worst first."""
    rows: dict[FindingKind, list[tuple[str, str]]] = {kind: [] for kind in FindingKind}
    for one in alerts:
        why = f"{one.kind.words}{one.detail}" if _terms(one.kind) else one.detail.lstrip(",: ")
        rows[one.kind.finding].append(("", one.text) if one.kind is GATEWAY else (one.target.partition("#")[0], why))
    return tuple(kind.finding(some[:MOST_SHOWN], total=len(some)) for kind, some in rows.items() if some)


def _values(kind: AlertKind, device: Device, part_id: str) -> list[tuple[StateIs, State]]:
    """Return the known values of a part that decide on *kind*, each with its term."""
    known = [one for one in device.states if one.part == part_id and one.value.plain() is not None]
    return [(term, one) for term in _terms(kind) for one in known if one.capability == term.capability]


def _is_door(device: Device, part: DevicePart) -> bool:
    """Return whether it is a door by its kind, or by its name if it declares none: an open window is no alert."""
    is_declared = part.part.tag in _DOOR_TAGS or part.part.service_type == "closure"
    return is_declared or bool(matching_words(f"{device.name} {part.part.name}", frozenset({"entry"})))


def _detail(device: Device, states: list[State], since: float, now: float) -> str:
    """Return the charge of a battery, and why the values may be out of date, or for how long they have lasted."""
    charge = f" ({states[0].value.number:.0f} %)" if states[0].capability == "battery" else ""
    if device.reachable.state == "no":
        return f"{charge}, by an old report: it is unreachable now"
    if device.freshness == "stale":
        return f"{charge}, by an old report: last seen {ago(device.last_seen, now)}"
    if not any(one.live for one in states):
        return f"{charge}, by a kept report: it has not reported itself yet"
    return f"{charge}, for {age_text(now - since)}" if now - since >= 60.0 else charge
