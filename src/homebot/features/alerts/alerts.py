"""Alerts: tells people of a fault in the house, once for each cause, of its end, and of a question of a program."""

import math
from collections.abc import Container, Iterable, Mapping
from datetime import datetime, timedelta
from functools import lru_cache, partial
from typing import Annotated, Final, NamedTuple

import anyio
from anyio import to_thread
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from homebot.apps.base import App, AppSettings
from homebot.config import AlertKey, Config, Language, Urgency, parse_settings
from homebot.control.gateway_feed import watch_gateways
from homebot.devices.device import ChangedSettings, Device, DeviceChange
from homebot.devices.findings import Finding, FindingKind, Findings
from homebot.devices.gateway_messages import GatewayState
from homebot.devices.names import (
    ALERT_FINDINGS,
    DEVICE_CHANGES,
    DEVICE_SETTINGS,
    FIND_DEVICES,
    OPEN_QUESTIONS,
    GatewayNames,
)
from homebot.devices.query.term_messages import QueryTerm, query_terms
from homebot.devices.query.terms import Or
from homebot.devices.question_messages import OpenQuestions
from homebot.devices.services import FindDevices, FindDevicesRequest
from homebot.errors import ServiceError
from homebot.feature_context import FeatureContext
from homebot.features.alerts import FEATURE, SEE_ALERTS, TEST_ALERTS
from homebot.features.alerts.alert_table import (
    ALERTS,
    GATEWAY,
    WATCHED,
    Alert,
    Asked,
    alerts_of,
    findings_of,
    fitting,
    held_alerts_of,
    is_over,
    kind_of,
    say,
)
from homebot.graph import qos_profile_latched
from homebot.messages.std_srvs import SuccessResponse, Trigger, TriggerRequest
from homebot.support.bounded_map import BoundedMap
from homebot.units import DURATION
from homebot.words.vocabulary import HOUSEHOLD

MAX_INCIDENTS: Final = 100
"""The limit of those that last, the worst first, and of all others; of more alerts people are not told."""

_GATHER_S, _MIN_PAUSE_S, _MAX_PAUSE_S = 0.5, 60.0, 3600.0
"""Seconds for which changes are gathered, between looks while something is wrong, and after unsent notifications."""

_CALM, _LONG_CALM, _DAY = 300.0, 3600.0, 86_400.0
"""Seconds for which it must be over before people are told so; the longer time if it came back within a day."""

_REPEATED: Final = (300.0, 3600.0)
"""Seconds until what is urgent is told again, unless seen: at first, and at most, as each pause is twice the last."""

_MAX_ALONE: Final = 8
"""The limit of urgent messages at a time; the last one tells the rest."""

_DAILY_HOUR: Final = 10
"""The hour at which people are told of what can wait, once a day."""

_WHILE_AWAY: Final = 60.0
"""Seconds after which people are told of an open door while all of them are known to be away."""

_AT_HOME: Final = "at_home"

_MAX_LINES: Final = 10
_MAX_ASKED: Final = 100


class AlertsSettings(AppSettings):
    """Settings of the alerts.

    Attributes:
        told_after: Seconds after which people are told of a kind, by its key, in place of those of the table.
        language: The language of texts for people.
    """

    told_after: dict[str, float] = Field(default_factory=dict)
    language: Language = "en"


def _or_never(value: object) -> object:
    return math.inf if value is False else value


class _AlertTimes(BaseModel):
    model_config = ConfigDict(extra="forbid")

    alerts: dict[AlertKey, Annotated[float, DURATION, BeforeValidator(_or_never), Field(ge=0)]]


def read_alerts(config: Config) -> dict[AlertKey, float]:
    """Return the table ``[alerts]``: seconds after which people are told of each kind; infinite for never.

    Raises:
        ConfigError: It is wrong.
    """
    return parse_settings(_AlertTimes, {"alerts": config.features["alerts"]}, config.source, "", config.folder).alerts


async def notify_people(house: FeatureContext) -> None:
    """Tell people of alerts until cancelled."""
    settings = AlertsSettings(told_after=house.table("alerts") or {}, language=house.home.language)
    await house.run_app(FEATURE.name, Alerts, settings)


class Incident(NamedTuple):
    """One cause of alerts, until a day after its end at *over_at*; times in seconds since the Unix epoch, or 0.

    Attributes:
        since: When it began, also while an unknown value hides whether it lasts; 0 once it is over.
        told_at: When people were told of it last.
        repeats: How often they were told of it again; -1 once they have seen it.
    """

    since: float
    end_text: str = ""
    is_told: bool = False
    over_at: float = 0.0
    times: int = 0
    text: str = ""
    told_at: float = 0.0
    repeats: int = 0

    def lasting(self, alert: Alert, now: float, language: Language = "en") -> "Incident":
        """Return it with its present *alert*; one that was over begins anew."""
        since = self.since or min(alert.since or now, now)
        return self._replace(since=since, over_at=0.0, end_text=alert.over(language), text=alert.told(language))

    def repeats_at(self, urgency: Urgency) -> float:
        """Return when people are to be told again that it lasts."""
        if not self.is_told or self.over_at or urgency != "high" or not self.text or self.repeats < 0:
            return math.inf
        return self.told_at + min(_REPEATED[0] * 2.0**self.repeats, _REPEATED[1])

    def due(self, told_after: float, urgency: Urgency = "normal") -> float:
        """Return when people are to be told that it began or, if they were, that it is over or lasts."""
        if self.is_told == (not self.over_at):
            return self.repeats_at(urgency)
        return self.since + told_after if not self.is_told else self.over_at + (_CALM if self.times < 2 else _LONG_CALM)


def update_incidents(
    before: Mapping[str, Incident],
    alerts: Mapping[str, Alert],
    ended: Container[str],
    now: float,
    language: Language = "en",
) -> dict[str, Incident]:
    """Return the incidents by key with the present *alerts*, and those that have *ended*. Pure."""
    known_now = {
        key: incident if key in alerts else _hidden(incident, now, is_over=key in ended)
        for key, incident in before.items()
    }
    incidents = {key: incident for key, incident in known_now.items() if _is_remembered(incident, now)}
    for key, alert in list(alerts.items())[:MAX_INCIDENTS]:
        incidents[key] = incidents.pop(key, Incident(0.0)).lasting(alert, now, language)
    return dict(list(incidents.items())[-2 * MAX_INCIDENTS :])


def _hidden(incident: Incident, now: float, *, is_over: bool) -> Incident:
    """Return an incident without a present alert; of one that was told, only an end that is known counts."""
    if is_over:
        return incident._replace(since=0.0, over_at=incident.over_at or now)
    return incident if incident.is_told or incident.over_at else incident._replace(over_at=now)


def _is_remembered(incident: Incident, now: float) -> bool:
    """Return whether it is not over, is still to be told as over, or may come again within a day."""
    may_return = bool(incident.times or incident.since) and now < incident.over_at + _DAY
    return incident.is_told or not incident.over_at or may_return


class Alerts(App[AlertsSettings]):
    """Publishes what is wrong on ``/alerts/findings``, and tells people of it through ``[notify]``."""

    async def run(self) -> None:
        """Look at the house whenever something may be wrong, or over."""
        node = self.node
        if self.settings.language != "en":
            await to_thread.run_sync(say, "Alert", self.settings.language)  # reads the table
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._findings = node.create_publisher(Findings, ALERT_FINDINGS, qos_profile_latched)
        self._incidents = {key: Incident(*fields) for key, fields in self.store.get("incidents", {}).items()}
        self._gateways: dict[str, Alert | None] = {}
        self._fitting: dict[str, tuple[Device, Asked, Asked]] = {}
        self._is_empty = False
        self._shown: tuple[Finding, ...] = ()
        self._published: Findings | None = None
        self._changed, self._pause = anyio.Event(), _MIN_PAUSE_S / 2
        node.create_subscription(ChangedSettings, DEVICE_SETTINGS, self._on_values, 100)
        node.create_subscription(DeviceChange, DEVICE_CHANGES, lambda _: self._changed.set(), 1)
        node.create_task(self._follow_gateways)
        node.create_service(Trigger, SEE_ALERTS.name, self._on_seen)
        node.create_service(Trigger, TEST_ALERTS.name, self._on_test)
        self._asked = BoundedMap[str, None](_MAX_ASKED)
        node.create_subscription(OpenQuestions, OPEN_QUESTIONS, self._on_questions, qos_profile_latched)
        while True:
            await anyio.sleep(_GATHER_S)
            self._changed = anyio.Event()
            with anyio.move_on_after(await self._look()):
                await self._changed.wait()

    async def _follow_gateways(self) -> None:
        followed = set[str]()
        async for gateway in watch_gateways(self.node.graph):
            if gateway not in followed:
                followed.add(gateway)
                on_state = partial(self._on_gateway, gateway)
                self.node.create_subscription(GatewayState, GatewayNames(gateway).state, on_state, qos_profile_latched)

    def _on_values(self, changed: ChangedSettings) -> None:
        if any(change.capability in WATCHED for change in changed.changes):
            self._changed.set()

    async def _on_seen(self, _: TriggerRequest) -> SuccessResponse:
        """Tell nothing again that lasts now."""
        for key, incident in self._incidents.items():
            if incident.is_told and not incident.over_at:
                self._incidents[key] = incident._replace(repeats=-1)
        self.store["incidents"] = self._incidents
        self._publish()
        return SuccessResponse(success=True, message="")

    async def _on_test(self, _: TriggerRequest) -> SuccessResponse:
        """Send a message to the owner's addresses, and return the problem of any."""
        if not self.context.notifies():
            return SuccessResponse(success=False, message="there is no address: [notify] has none")
        language, app = self.settings.language, f"{self.node.name} (test)"
        sent = await self.context.notify(say("homebot can reach you here.", language), say("Test", language), app)
        problem = self.context.not_sent_because() or ("" if sent else "too many tests: wait for 10 s")
        return SuccessResponse(success=not problem, message=problem)

    def _publish(self) -> None:
        repeats = (incident.repeats_at(kind_of(key).urgency) < math.inf for key, incident in self._incidents.items())
        message = Findings(findings=self._shown, repeats=self.context.notifies() and any(repeats))
        if message != self._published:
            self._published = message
            self._findings.publish(message)

    def _on_questions(self, asked: OpenQuestions) -> None:
        """Send the new questions at once, as each lasts a minute; a flood of them holds no alert back."""
        for question in asked.questions:
            if question.question not in self._asked:
                self._asked[question.question] = None
                how = f"homebot answer {question.question} yes (or no), or on the page, within a minute"
                self.node.create_task(partial(self._send_question, f"{question.text}? Answer: {how}"))

    async def _send_question(self, text: str) -> None:
        await self.context.notify(text, "Question", f"{self.node.name} (questions)")

    def _on_gateway(self, name: str, state: GatewayState) -> None:
        known = self._gateways.get(name) or Alert(GATEWAY, name, f"gateway {name}", self.clock.now())
        self._gateways[name] = None if state.state == "active" else known._replace(why=f": {state.reason}")
        self._changed.set()

    async def _look(self) -> float:
        """Look at the house, publish what is wrong and tell the news; return the seconds until the next look."""
        now = self.clock.now()
        try:
            alerts = await self._alerts(now)
            ended, held = await self._sort_ended(self._incidents.keys() - alerts.keys(), now)
        except ServiceError:
            return _MIN_PAUSE_S
        self._shown = findings_of(alert for alert in alerts.values() if alert.is_shown(now))
        self._publish()
        lasting = alerts | held
        self._incidents = update_incidents(self._incidents, lasting, ended, now, self.settings.language)
        is_told = await self._publish_news(now)
        self._publish()
        if self._incidents or "incidents" in self.store:
            self.store["incidents"] = self._incidents
        self._pause = _MIN_PAUSE_S / 2 if is_told else min(2 * self._pause, _MAX_PAUSE_S)
        wait = min(map(self._due, self._incidents), default=math.inf) - now
        return max(0.0, min(wait, _MIN_PAUSE_S if lasting else math.inf)) if is_told else self._pause

    async def _publish_news(self, now: float) -> bool:
        """Tell people what began, lasts or ended; return False if some of that failed."""
        due = [key for key in self._incidents if self._due(key) <= now]
        sent = []
        for title, keys in (
            ("Alert", [key for key in due if not self._incidents[key].over_at]),
            ("Over", [key for key in due if self._incidents[key].over_at]),
        ):
            alone = [key for key in keys if kind_of(key).urgency == "high"]
            groups = [[key] for key in alone[: _MAX_ALONE - 1]] + [alone[_MAX_ALONE - 1 :]]
            rest = [key for key in keys if key not in alone]
            kinds = dict.fromkeys(map(kind_of, rest))
            groups += [[key for key in rest if kind_of(key) is kind] for kind in kinds]
            sent += [await self._send_news(title, group, now) for group in groups if group]
        return all(sent)

    async def _alerts(self, now: float) -> dict[str, Alert]:
        """Return the present alerts by cause, the worst first."""
        lost = tuple(name for name, alert in self._gateways.items() if alert is not None)
        asked, query = _asked(lost)
        devices = await self._devices(query, ())
        self._is_empty = _is_nobody_home(devices)
        alerts = [alert for alert in self._gateways.values() if alert is not None]
        known, self._fitting = self._fitting, {}
        for device in devices:  # most are as they were a minute ago
            if (kept := known.get(device.id)) is None or kept[0] is not device or kept[1] is not asked:
                kept = device, asked, fitting(asked, device)
            self._fitting[device.id] = kept
        alerts += [alert for device, _, kinds in self._fitting.values() for alert in alerts_of(kinds, device, now)]
        return {alert.key: alert for alert in sorted(alerts, key=lambda alert: _ORDER[alert.kind.finding])}

    async def _sort_ended(self, keys: Iterable[str], now: float) -> tuple[set[str], dict[str, Alert]]:
        """Return those of *keys* that are known to be over, and those that are not, though they would not begin now."""
        targets = {key: key.partition(" ")[2].partition("#")[0] for key in keys}
        devices = {device.id: device for device in await self._devices((), tuple(targets.values()))} if targets else {}
        held = {alert.key: alert for device in devices.values() for alert in held_alerts_of(device, now)}
        held = {key: alert for key, alert in held.items() if key in targets and not self._incidents[key].over_at}
        working = {f"{GATEWAY.key} {name}" for name, alert in self._gateways.items() if alert is None}
        over = {key for key, device_id in targets.items() if device_id in devices and is_over(key, devices[device_id])}
        return working | over - held.keys(), held

    async def _devices(self, query: tuple[QueryTerm, ...], ids: tuple[str, ...]) -> tuple[Device, ...]:
        return (await self._find.call(FindDevicesRequest(query=query, ids=ids))).devices

    async def _send_news(self, title: str, keys: list[str], now: float) -> bool:
        """Tell people the news about *keys*; return False if that failed, to be tried again."""
        language, kind = self.settings.language, kind_of(keys[0])
        texts = [
            incident.end_text if incident.over_at else incident.text
            for incident in map(self._incidents.__getitem__, keys)
        ]
        more = [say("… and {count} more", language, count=str(len(texts) - _MAX_LINES))]
        text = "\n".join(texts[:_MAX_LINES] + (more if len(texts) > _MAX_LINES else []))
        sent = await self.context.notify(text, say(title, language), self.node.name, kind.urgency, kind.key)
        if not sent and self.context.notifies():
            return False
        for key in keys:
            incident = self._incidents[key]
            is_repeated = incident.is_told and not incident.over_at
            self._incidents[key] = incident._replace(
                is_told=is_repeated or not incident.is_told,
                times=incident.times + (not incident.is_told),
                told_at=now,
                repeats=incident.repeats + 1 if is_repeated else 0,
            )
        return True

    def _due(self, key: str) -> float:
        kind, incident = kind_of(key), self._incidents[key]
        told_after = self.settings.told_after.get(kind.key, kind.told_after)
        if kind.key == "door" and self._is_empty and told_after < math.inf:
            told_after = min(told_after, _WHILE_AWAY)
        due = incident.due(told_after, kind.urgency)
        return self._next_daily(due) if kind.urgency == "low" and due < math.inf else due

    def _next_daily(self, time: float) -> float:
        """Return when people are next told of what can wait, at *time* or later."""
        zone = self.context.zone
        day = datetime.fromtimestamp(time, zone).replace(hour=_DAILY_HOUR, minute=0, second=0, microsecond=0)
        return (day if day.timestamp() >= time else day + timedelta(days=1)).timestamp()


_ORDER: Final = {kind: place for place, kind in enumerate(FindingKind)}


@lru_cache(maxsize=8)
def _asked(lost: tuple[str, ...]) -> tuple[Asked, tuple[QueryTerm, ...]]:
    """Return the query of each kind while the gateways *lost* are away, and that for all of them and for people."""
    asked = tuple((kind, kind.query(lost)) for kind in ALERTS)
    return asked, query_terms(Or((*(query for _, query in asked), HOUSEHOLD)))


def _is_nobody_home(devices: Iterable[Device]) -> bool:
    states = (state for device in devices for state in device.states)
    return any(state.capability == _AT_HOME and state.live and state.value.plain() is False for state in states)
