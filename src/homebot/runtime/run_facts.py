"""The facts of a run that a replay needs."""

import json

from homebot.apps import App
from homebot.apps.grants import ACT, queries_of
from homebot.clock import zone_name
from homebot.config import HomeSettings
from homebot.control import ControlSettings
from homebot.messages import Time
from homebot.places import HousePlan, places_text
from homebot.recording.lines import FORMAT, RecordedApp, RecordingHeader
from homebot.recording.secrets import public_settings
from homebot.runtime.plan import Plan, PlannedComponent
from homebot.version import __version__


def run_facts(plan: Plan, detected: tuple[str, ...], *, trusts_apps: bool, approves_all: bool) -> RecordingHeader:
    """Return the facts of a run with its effective settings, without secrets; the start time is missing.

    Args:
        detected: The motion sensors that have ever detected a person.
    """
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
        apps=tuple(_record(app, plan) for app in plan.apps),
        home_table=_home_table(plan.home_settings),
    )


def _record(app: PlannedComponent[App], plan: Plan) -> RecordedApp:
    settings = public_settings(app.settings)
    if (scope := plan.grants.now.scopes.get(f"/{app.name}")) is not None:
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
