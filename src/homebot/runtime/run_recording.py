"""The recording of a run with the facts that a replay needs; a client may start one."""

import json
from collections.abc import Awaitable, Callable
from functools import partial
from typing import final

import anyio
from anyio.abc import TaskStatus

from homebot.apps import App
from homebot.apps.grants import ACT, queries_of
from homebot.clock import zone_name
from homebot.config import HomeSettings
from homebot.control import ControlSettings
from homebot.devices.names import START_RECORDER
from homebot.graph import Graph, Node
from homebot.messages import Time
from homebot.messages.std_srvs import SuccessResponse, Trigger, TriggerRequest
from homebot.places import HousePlan, places_text
from homebot.recording.lines import FORMAT, RecordedApp, RecordingHeader
from homebot.recording.recording_file import LineSink
from homebot.recording.secrets import public_settings
from homebot.recording.session import record_for_client, record_into
from homebot.runtime.plan import Plan, PlannedComponent
from homebot.support.isolation import run_as
from homebot.version import __version__

BUSY = "another client is recording; homebot makes one recording for clients at a time"

_READY_WITHIN = 10.0


@final
class RunRecording:
    """Records a run, for whoever started it and for clients, these one at a time.

    Args:
        plan: Returns the current plan.
        detected: Returns the motion sensors that have ever detected a person.
    """

    def __init__(
        self,
        graph: Graph,
        plan: Callable[[], Plan],
        detected: Callable[[], Awaitable[tuple[str, ...]]],
        *,
        trusts_apps: bool,
        approves_all: bool,
    ) -> None:
        self._graph, self._plan, self._detected = graph, plan, detected
        self._trusts_apps, self._approves_all = trusts_apps, approves_all
        self._is_busy = False

    async def record_into(self, sink: LineSink, *, task_status: TaskStatus[None]) -> None:
        """Record into *sink* until cancelled."""
        facts = await self._facts()
        async with Node(self._graph, "file_recorder", namespace="/homebot") as node:
            await run_as(node.full_name, partial(record_into, node, facts, sink, task_status=task_status))

    def serve_clients(self, main: Node) -> None:
        """Start recorders for clients through a service of the runtime's node, which runs their tasks."""
        main.create_service(Trigger, START_RECORDER, partial(self._start, main))

    async def _start(self, main: Node, _: TriggerRequest) -> SuccessResponse:
        if self._is_busy:
            return SuccessResponse(success=False, message=BUSY)
        self._is_busy = True
        ready = anyio.Event()
        main.create_task(partial(self._record, main, ready))
        with anyio.move_on_after(_READY_WITHIN):
            await ready.wait()
        return SuccessResponse(success=ready.is_set(), message="" if ready.is_set() else "the recorder did not start")

    async def _record(self, main: Node, ready: anyio.Event) -> None:
        try:
            facts = await self._facts()
            async with Node(self._graph, "recorder", namespace=main.full_name) as node:
                await run_as(node.full_name, partial(record_for_client, node, facts, ready))
        finally:
            self._is_busy = False

    async def _facts(self) -> RecordingHeader:
        """Return the facts of the run with its effective settings, without secrets; the start time is missing."""
        plan, detected = self._plan(), await self._detected()
        control = plan.control or ControlSettings()
        if self._approves_all:
            control = control.model_copy(update={"approvals": False})
        return RecordingHeader(
            format=FORMAT,
            version=__version__,
            home=plan.home,
            started_at=Time.from_seconds(0.0),
            trusts_apps=self._trusts_apps,
            control=json.dumps(public_settings(control)),
            places=_places(plan),
            detected=detected,
            apps=tuple(_recorded(app, plan) for app in plan.apps),
            home_table=_home_table(plan.home_settings),
        )


def _recorded(app: PlannedComponent[App], plan: Plan) -> RecordedApp:
    settings = public_settings(app.settings)
    if (scope := plan.grants.get(f"/{app.name}")) is not None:
        settings[ACT] = queries_of(scope)
    kind = f"{app.kind.__module__}:{app.kind.__qualname__}"
    return RecordedApp(name=app.name, kind=kind, settings=json.dumps(settings))


def _home_table(home: HomeSettings) -> str:
    """Return the table ``[home]`` without the name, and with the zone if it is the computer's."""
    table = home.model_dump(exclude={"name"}, exclude_none=True)
    return json.dumps(table | {"zone": zone_name(home.zone)})


def _places(plan: Plan) -> str:
    places = plan.places
    if not places.rooms and not places.devices:
        return ""
    devices = ((names[0], facts, names) for names, facts in places.devices.items())
    return places_text(HousePlan(plan.home, places.rooms, doors=places.doors), devices)
