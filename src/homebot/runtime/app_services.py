"""The services for apps: their list, with states and jobs, and their change."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable
from typing import Final

from homebot.apps import App
from homebot.apps.jobs import Job
from homebot.clock import zone_name
from homebot.devices.app_messages import (
    AppInfo,
    AppJob,
    AppsRequest,
    AppsResponse,
    ChangeAppRequest,
    ChangeAppResponse,
    ListApps,
    LoadApp,
    ReloadApp,
    UnloadApp,
)
from homebot.devices.names import LIST_APPS, LOAD_APP, RELOAD_APP, UNLOAD_APP
from homebot.errors import HomebotError
from homebot.graph import Node
from homebot.messages import Time
from homebot.runtime.app_host import AppHost
from homebot.runtime.supervisor import ComponentCrashes, Supervisor

__all__ = ["serve_app_list", "serve_change"]

_TYPES: Final = {LOAD_APP: LoadApp, UNLOAD_APP: UnloadApp, RELOAD_APP: ReloadApp}


def serve_change(node: Node, service: str, change: Callable[[str], Awaitable[str]]) -> None:
    """Serve *service*, which changes an app by its name, or says why not."""

    async def answer(request: ChangeAppRequest) -> ChangeAppResponse:
        try:
            return ChangeAppResponse(message=await change(request.app))
        except HomebotError as exc:
            return ChangeAppResponse(success=False, message=str(exc))

    node.create_service(_TYPES[service], service, answer)


def serve_app_list(node: Node, names: Callable[[], Iterable[str]], host: AppHost, supervisor: Supervisor) -> None:
    """Serve the list of apps on *node*."""

    def answer(_request: AppsRequest) -> AppsResponse:
        infos = (_info(name, host.running.get(name), supervisor.crashes.get(name)) for name in names())
        return AppsResponse(apps=tuple(infos), zone=zone_name(host.context.zone_name))

    node.create_service(ListApps, LIST_APPS, answer)


def _info(name: str, app: App | None, crashes: ComponentCrashes | None) -> AppInfo:
    jobs = () if app is None else tuple(map(_job, app.jobs))
    if crashes is None:
        return AppInfo(name=name, state="running" if app is not None else "ended", jobs=jobs)
    state = crashes.state if app is None else "running"
    return AppInfo(name=name, state=state, crashes=crashes.count, last_crash=crashes.last, jobs=jobs)


def _job(job: Job) -> AppJob:
    at = job.next
    return AppJob(
        name=job.name,
        text=job.text,
        next=Time.from_seconds(0.0 if at is None else at.timestamp()),
        running_since=Time.from_seconds(job.runs.running_since or 0.0),
        dropped=job.runs.dropped,
        note=job.note,
    )
