"""A service of our own: the present problems, as ``homebot doctor`` and the page show it."""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Awaitable, Callable, Collection, Iterable, Iterator, Mapping
from functools import partial
from operator import attrgetter
from typing import TypeVar

import anyio

from homebot.conventions.ecosystem import ecosystems
from homebot.conventions.vacuum_map import map_readers
from homebot.devices import QUERY_DEVICES, Device, GatewayState, QueryDevices
from homebot.devices.findings import MAX_SHOWN, DeviceCheck, Finding, FindingKind, Row
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse, PartFailure
from homebot.devices.names import (
    MACHINE_NODE,
    NEEDS_GATEWAY,
    NEXT_STEP,
    SENDS_NOTHING,
    SEVERAL_NAMES,
    UNREADABLE,
    GatewayNames,
)
from homebot.devices.query.term_messages import query_terms
from homebot.devices.query.terms import Query
from homebot.devices.services import QueryDevicesRequest, QueryDevicesResponse
from homebot.devices.wording.time_format import age, ago
from homebot.errors import ServiceError
from homebot.feature import all_features, load
from homebot.graph import EntityKind, Node, qos_profile_latched
from homebot.messages.message import Message, ServiceType, UInt32
from homebot.support.counters import Severity
from homebot.support.folding import fold
from homebot.support.production_loop import load_beside_loop
from homebot.words.queries import parse_query

_ANSWERS_WITHIN = 2.0
"""Seconds for the state of a gateway that has just started, which is kept for late joiners, and for a node's health."""

_LOOK_EVERY = 300.0
"""Seconds between two looks at the counts: what they count since the look before the last is new."""

_DAY = 86_400.0

_RANKS = {kind.code: rank for rank, kind in enumerate(FindingKind)}

RequestT = TypeVar("RequestT", bound=Message)
ResponseT = TypeVar("ResponseT", bound=Message)
AnswerT = TypeVar("AnswerT")


class ExamineRequest(Message):
    """A question for the present problems.

    Attributes:
        counts: Whether counts are told that are no fault.
        gateways_only: Whether only the gateways are examined.
    """

    counts: bool = False
    gateways_only: bool = False


class ExaminedGateway(Message):
    """A gateway.

    Attributes:
        state: As of :class:`homebot.devices.GatewayState`, or ``silent``.
        text: The same in words.
    """

    name: str
    state: str
    text: str


class ExamineResponse(Message):
    """The findings, problems and notes as they come, and the devices they were sought among.

    Attributes:
        devices: How many there are.
        unconfirmed: How many of them are known from retained announcements alone.
    """

    gateways: tuple[ExaminedGateway, ...]
    devices: UInt32
    unconfirmed: UInt32
    findings: tuple[Finding, ...]


Examine = ServiceType("homebot/srv/Examine", ExamineRequest, ExamineResponse)


def serve(node: Node, vacuums: Collection[str] = ()) -> None:
    """Offer the service on *node*; *vacuums* are the topics of those that are robots."""
    node.create_service(Examine, "/rosapi/doctor", _Doctor(node, vacuums).examine)


class _Doctor:
    """Asks the parts of homebot, and the directory, as any node can."""

    def __init__(self, node: Node, vacuums: Collection[str]) -> None:
        self._node, self._vacuums = node, vacuums
        self._looks: deque[dict[str, HealthResponse]] = deque([{}], maxlen=2)
        node.create_timer(_LOOK_EVERY, self._look)

    async def _look(self) -> None:
        self._looks.append(await self._all_health())

    async def _all_health(self) -> dict[str, HealthResponse]:
        """Return the health of each node."""
        services = [service.name for service in self._node.graph.get_services_of_type(GetHealth.ros_type)]
        return await _ask_all(self._health, services)

    async def examine(self, request: ExamineRequest) -> ExamineResponse:
        await load_beside_loop(_load_checks)
        now = self._node.graph.clock.now()
        total, unconfirmed = [(await self._find(parse_query(query), 1)).total for query in ("", "unconfirmed")]
        publishers = self._node.graph.get_endpoints(kind=EntityKind.PUBLISHER)
        topics = {publisher.name for publisher in publishers if publisher.ros_type == GatewayState.ros_type}
        states = await _ask_all(
            self._state, sorted(topic.split("/")[2] for topic in topics if re.fullmatch("/gateway/[^/]+/state", topic))
        )
        findings = [finding for name, state in states.items() for finding in gateway_finding(name, state)]
        if not request.gateways_only:
            findings += await self._health_findings(now, everything=request.counts)
            lost = [name for name, state in states.items() if state is None or state.state != "active"]
            findings += await self._device_findings(now, lost)
        findings.sort(key=lambda finding: _RANKS[finding.code])
        gateways = tuple(
            ExaminedGateway(
                name=name, state="silent" if gateway is None else gateway.state, text=_gateway_line(name, gateway)
            )
            for name, gateway in states.items()
        )
        return ExamineResponse(gateways=gateways, devices=total, unconfirmed=unconfirmed, findings=tuple(findings))

    async def _health_findings(self, now: float, *, everything: bool) -> list[Finding]:
        """Return the findings from the health of the nodes, with their counts since the last look."""
        findings: list[Finding] = []
        for service, health in (await self._all_health()).items():
            before = self._looks[0].get(service)
            counted = () if before is None else before.counts
            name = service.removesuffix("/health").strip("/")
            findings += health_findings(name, health, now, counted, everything=everything)
        return findings

    async def _state(self, gateway: str) -> GatewayState | None:
        states = self._node.create_subscription(GatewayState, GatewayNames(gateway).state, None, qos_profile_latched)
        try:
            with anyio.move_on_after(_ANSWERS_WITHIN):
                return await states.receive()
        finally:
            states.close()
        return None

    async def _health(self, service: str) -> HealthResponse:
        try:
            return await self._call(GetHealth, service, HealthRequest(), _ANSWERS_WITHIN)
        except ServiceError as exc:
            return HealthResponse(counts=(), troubles=(str(exc),))

    async def _find(self, query: Query, limit: int) -> QueryDevicesResponse:
        if self._node.graph.get_node(MACHINE_NODE) is not None:
            return QueryDevicesResponse(success=True, message="")
        request = QueryDevicesRequest(query=query_terms(query), limit=limit)
        return await self._call(QueryDevices, QUERY_DEVICES, request)

    async def _call(
        self,
        service_type: ServiceType[RequestT, ResponseT],
        service: str,
        request: RequestT,
        within: float = 5.0,
    ) -> ResponseT:
        client = self._node.create_client(service_type, service)
        try:
            return await client.call(request, within)
        finally:
            client.close()

    async def _device_findings(self, now: float, lost: Iterable[str]) -> list[Finding]:
        """Return the findings about devices: those of features, and others."""
        findings = []
        vacuums = (
            DeviceCheck(FindingKind.VACUUM, f'"origin"={reader.origin}', self._table) for reader in map_readers()
        )
        of_features = (check for feature in all_features() if feature.checks for check in load(feature.checks)(lost))
        for check in (*of_features, *_DEVICE_CHECKS, *_unused(), *vacuums):
            response = await self._find(check.asked or parse_query(check.query), check.most)
            rows = sorted(
                (result.device.id, text) for result in response.results for text in check.reasons(result.device, now)
            )
            if rows:
                total = response.total - len(response.results) + len(rows)
                hint = f"; all: homebot find --limit {total} '{check.query}'"
                finding = check.kind.finding(rows[: check.most], total=total)
                findings.append(finding.model_copy(update={"hint": hint}))
        return findings

    def _table(self, device: Device, _now: float) -> Iterator[str]:
        """Yield the table that makes the vacuum *device* a robot, if it is none."""
        topics = [topic.split("/") for part in device.parts for topic in (*part.part.reads, *part.part.writes)]
        for base, name in sorted((topic[0], topic[1]) for topic in topics if len(topic) > 2)[:1]:
            robot = re.sub(r"[^a-z0-9]+", "_", fold(name)).strip("_")
            table = f"[robots.{robot if robot[:1].isalpha() else f'vacuum_{robot}'}]"
            if f"{base}/{name}" not in self._vacuums:
                yield f'add {table} with vacuum = "{base}/{name}"'


async def _ask_all(ask: Callable[[str], Awaitable[AnswerT]], names: Iterable[str]) -> dict[str, AnswerT]:
    """Return the answers by name: all are asked at once, as some may be silent."""
    answers: dict[str, AnswerT] = {}

    async def add(name: str) -> None:
        answers[name] = await ask(name)

    async with anyio.create_task_group() as tasks:
        for name in names:
            tasks.start_soon(add, name)
    return dict(sorted(answers.items()))


def gateway_finding(name: str, state: GatewayState | None) -> Iterator[Finding]:
    """Yield the finding about a gateway that does not work."""
    if state is None or state.state != "active":
        kind = FindingKind.SILENT_GATEWAY if state is None else FindingKind.GATEWAY
        yield kind.finding([("", _gateway_line(name, state))], f"gateway/{name}")


def _gateway_line(name: str, state: GatewayState | None) -> str:
    if state is None:
        return f"gateway {name} does not report its state"
    acts = " and sends commands" if state.acts and state.reason != SENDS_NOTHING else " and only observes"
    reason = f": {state.reason}" if state.reason else ""
    return f"gateway {name} is {state.state}{acts if state.state == 'active' else ''}{reason}"


def health_findings(
    name: str, health: HealthResponse, now: float, counted: Iterable[Count] = (), *, everything: bool
) -> Iterator[Finding]:
    """Yield the findings about a node.

    Args:
        counted: Its counts of about ten minutes ago.
        everything: Whether counts are told that are no fault.
    """
    rows_by_kind: dict[FindingKind, list[Row]] = {kind: [] for kind in FindingKind}
    for kind, row in _health_rows(health, now, counted, everything=everything):
        rows_by_kind[kind].append(row)
    for kind, rows in rows_by_kind.items():
        if rows:
            yield kind.finding(rows[:MAX_SHOWN] if kind in _CUT else rows, name, len(rows))


_CUT = {FindingKind.FAILURE, FindingKind.QUARANTINE}


def _health_rows(
    health: HealthResponse, now: float, counted: Iterable[Count], *, everything: bool
) -> Iterator[tuple[FindingKind, Row]]:
    for text in health.troubles:
        yield FindingKind.TROUBLE, ("", text)
    for text in health.notes:
        yield FindingKind.NOTE, ("", text)
    yield from _count_rows(health.counts, {count.name: count.count for count in counted}, everything=everything)
    for failure in health.failures:
        yield FindingKind.GIVEN_UP if failure.outcome == "given up" else FindingKind.FAILURE, _failure(failure, now)
    for quarantined in health.quarantined:
        text = f"for {age(quarantined.since, now)}, {quarantined.offences} offences, the last: {quarantined.why}"
        yield FindingKind.QUARANTINE, (quarantined.offender, text)


def _count_rows(
    counts: Iterable[Count], before: Mapping[str, int], *, everything: bool
) -> Iterator[tuple[FindingKind, Row]]:
    for count in counts:
        words, new = count.name.replace("_", " "), count.count - before.get(count.name, 0)
        if new > 0 and count.severity is Severity.LOSS:
            yield FindingKind.LOSS, (words, str(new))
        elif everything or (count.count and count.severity is not Severity.NORMAL):
            yield FindingKind.COUNT, (words, str(count.count))


def _failure(failure: PartFailure, now: float) -> Row:
    times = "once" if failure.count == 1 else f"{failure.count} times"
    outcome = f"; now {failure.outcome}" if failure.outcome else ""
    return (failure.part, f"{failure.what} {times}, {ago(failure.last, now)}: {failure.why}{outcome}")


def _dispute(device: Device, _now: float) -> Iterator[str]:
    more = len(device.conflicts) - 1
    yield device.conflicts[0] + (f" (and {more} more: homebot show '{device.id}')" if more else "")


def _unread(device: Device, now: float) -> Iterator[str]:
    """Yield the values of *device* in the last day that could not be read."""
    facts = [fact for fact in device.facts if fact.name == UNREADABLE]
    last = max(facts, key=lambda fact: fact.said_at.to_seconds(), default=None)
    if last is not None and last.said_at.to_seconds() >= now - _DAY:
        more = f" (and {len(facts) - 1} more: homebot show '{device.id}')" if len(facts) > 1 else ""
        yield f"{ago(last.said_at, now)}: {last.value}{more}"


def _step(shared: Collection[str], device: Device, _now: float) -> Iterator[str]:
    """Yield the next step with *device*, rather with a gateway of its own than with one of *shared* ones."""
    needed = {(fact.gateway, fact.key): fact.value for fact in device.facts if fact.name == NEEDS_GATEWAY}
    steps = [
        (needed.get((fact.gateway, fact.key)) in shared, fact.value) for fact in device.facts if fact.name == NEXT_STEP
    ]
    yield min(steps, default=(False, ""))[1]


def _load_checks() -> None:
    """Load the modules that the checks ask for."""
    ecosystems()
    map_readers()
    for feature in all_features():
        if feature.checks:
            load(feature.checks)


def _unused() -> Iterator[DeviceCheck]:
    """Yield the check for devices that no gateway uses; what has a gateway of its own needs no shared one."""
    known = sorted(
        (ecosystem for ecosystem in ecosystems() if ecosystem.gateway), key=attrgetter("is_shared", "gateway")
    )
    own = sorted(
        service_type.removesuffix(".local.")
        for kind in known
        if not kind.is_shared
        for service_type in kind.service_types
    )
    no_own = "".join(f' and not "dns_sd_type"={service_type}' for service_type in own)
    needs = [f'"{NEEDS_GATEWAY}"={kind.gateway}' for kind in known]
    needs = [f"({need}{no_own})" if kind.is_shared else need for kind, need in zip(known, needs, strict=True)]
    if needs:
        step = partial(_step, [kind.gateway for kind in known if kind.is_shared])
        yield DeviceCheck(FindingKind.NO_GATEWAY, " or ".join(needs), step)


_DEVICE_CHECKS = (
    DeviceCheck(FindingKind.DISPUTED, "disputed", _dispute),
    DeviceCheck(FindingKind.UNREADABLE, UNREADABLE, _unread),
    DeviceCheck(
        FindingKind.NAMES,
        f'"{SEVERAL_NAMES}"=names',
        lambda device, _now: [fact.value for fact in device.facts if fact.name == SEVERAL_NAMES][:1],
    ),
    DeviceCheck(
        FindingKind.NO_ROOM,
        "without area and not (person or household or tracker or robot)",
        lambda device, _now: [device.name],
        5,
    ),
)
