"""The facts of a run that its recording needs for a replay."""

from __future__ import annotations

import json

from homebot.control import ControlSettings
from homebot.places.text import places_text
from homebot.recording.lines import RecordedApp
from homebot.recording.recorder import RunFacts
from homebot.recording.secrets import public_settings
from homebot.runtime.plan import ACT, Plan

__all__ = ["run_facts"]

_SCOPE = "act: "


def run_facts(plan: Plan, control: ControlSettings, *, trusts_apps: bool, detected: tuple[str, ...]) -> RunFacts:
    """Return the facts of a run of *plan*, with the settings of *control* that it has in truth, without secrets."""
    apps = []
    for app in plan.apps:
        settings = public_settings(app.settings)
        if (scope := plan.grants.get(f"/{app.name}")) is not None:
            settings[ACT] = [one.removeprefix(_SCOPE) for one in scope if one.startswith(_SCOPE)]
        kind = f"{app.kind.__module__}:{app.kind.__qualname__}"
        apps.append(RecordedApp(name=app.name, kind=kind, settings=json.dumps(settings)))
    table = json.dumps(public_settings(control))
    return RunFacts(plan.home, tuple(apps), table, trusts_apps, _places(plan), detected)


def _places(plan: Plan) -> str:
    """Return the table ``[places]`` as the text of a places file; empty where there is none."""
    places = plan.places
    if not places.rooms and not places.devices:
        return ""
    devices = ((names[0], facts, names) for names, facts in places.devices.items())
    return places_text(plan.home, places.rooms, devices)
