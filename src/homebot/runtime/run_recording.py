"""The recording of a run with the facts that a replay needs; a client may start one."""

import json
from collections.abc import Awaitable, Callable
from functools import partial
from typing import final

import anyio

from homebot.apps import App
from homebot.clock import zone_name
from homebot.config import HomeSettings
from homebot.control import ControlSettings
from homebot.devices.names import START_RECORDER
from homebot.graph import Node
from homebot.messages import Time
from homebot.messages.std_srvs import SuccessResponse, Trigger, TriggerRequest
from homebot.places import HousePlan, places_text
from homebot.recording.lines import FORMAT, RecordedApp, RecordingHeader
from homebot.recording.secrets import public_settings
from homebot.recording.session import record_for_client
from homebot.runtime.grants import ACT
from homebot.runtime.plan import Plan, PlannedComponent
from homebot.support.isolation import run_as
from homebot.version import __version__

__all__ = ["RecorderStarter", "facts_of_run"]

BUSY = "another client is recording; homebot makes one recording for clients at a time"

_READY_WITHIN = 10.0
_SCOPE = "act: "


def facts_of_run(plan: Plan, *, trusts_apps: bool, approves_all: bool, detected: tuple[str, ...]) -> RecordingHeader:
    """Return the facts of a run of *plan* with its effective settings, without secrets; the start time is missing."""
    control = plan.control or ControlSettings()
    if approves_all:
        control = control.model_copy(update={"approvals": False})
    return RecordingHeader(
        format=FORMAT,
        version=__version__,
        home=plan.home,
        started_at=Time.from_seconds(0.0),
        trusts_apps=trusts_apps,
        control=json.dumps(public_settings(control)),
        places=_places(plan),
        detected=detected,
        apps=tuple(_recorded(app, plan) for app in plan.apps),
        home_table=_home_table(plan.home_settings),
    )


@final
class RecorderStarter:
    """Starts recorders for clients, one at a time, through a service of the runtime's node, which runs their tasks."""

    def __init__(self, node: Node, facts: Callable[[], Awaitable[RecordingHeader]]) -> None:
        self._node = node
        self._facts = facts
        self._is_busy = False
        node.create_service(Trigger, START_RECORDER, self._start)

    async def _start(self, _: TriggerRequest) -> SuccessResponse:
        if self._is_busy:
            return SuccessResponse(success=False, message=BUSY)
        self._is_busy = True
        ready = anyio.Event()
        self._node.create_task(partial(self._record, ready))
        with anyio.move_on_after(_READY_WITHIN):
            await ready.wait()
        return SuccessResponse(success=ready.is_set(), message="" if ready.is_set() else "the recorder did not start")

    async def _record(self, ready: anyio.Event) -> None:
        try:
            facts = await self._facts()
            async with Node(self._node.graph, "recorder", namespace=self._node.full_name) as node:
                await run_as(node.full_name, partial(record_for_client, node, facts, ready))
        finally:
            self._is_busy = False


def _recorded(app: PlannedComponent[App], plan: Plan) -> RecordedApp:
    settings = public_settings(app.settings)
    if (scope := plan.grants.get(f"/{app.name}")) is not None:
        settings[ACT] = [one.removeprefix(_SCOPE) for one in scope if one.startswith(_SCOPE)]
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
