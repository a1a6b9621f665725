"""``homebot app`` and ``homebot reload``."""

from __future__ import annotations

import argparse
from datetime import tzinfo
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import Commands, add_verb, add_verbs
from homebot.cli.device_json import json_text, list_text
from homebot.cli.device_queries import house_time
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.local_time import local_text, next_text, zone_of
from homebot.cli.terminal import print_table
from homebot.devices.names import LIST_APPS, LOAD_APP, RELOAD, RELOAD_APP, UNLOAD_APP
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import iso
from homebot.errors import PeerError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.app_messages import AppInfo, AppJob, AppsResponse

_EXAMPLES = """\
  homebot app list                the apps, with the next calls of their jobs
  homebot app load hall.py        start an app from a file in the running homebot
  homebot app reload hall         reload its file and settings; if that fails, the old one keeps running
  homebot app unload hall         stop it until homebot restarts or it is loaded again

All but `list` need the right `manage`. An app's store is kept.
"""

_MAX_WAIT_S = 60.0
"""Seconds: an app may take ten to stop and ten to start, twice if it is rolled back."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list the apps with their jobs and the times of the next calls")
    set_door_command(command, _list, "  homebot app list --json\n")
    command.add_argument("--json", action="store_true", help="print a JSON list, times in ISO 8601 UTC")
    _add(verbs, "load", LOAD_APP, "start an app from the configuration, an installed package or a file")
    _add(verbs, "reload", RELOAD_APP, "restart an app with its current code and settings")
    _add(verbs, "unload", UNLOAD_APP, "stop an app")


def _add(verbs: Commands, name: str, service: str, summary: str) -> None:
    parser = add_verb(verbs, name, summary)
    set_door_command(parser, partial(_change, service), _EXAMPLES)
    what = "its name, or FILE.py, or FILE.py:CLASS" if service == LOAD_APP else "its name"
    parser.add_argument("app", metavar="APP", help=what)


def add_reload_arguments(parser: argparse.ArgumentParser) -> None:
    examples = """\
  homebot reload                    apply the changed tokens, rights, policies and places of the configuration
  homebot reload --allow-removal    also if some of them are missing, which may mean that the file is half saved

It needs the right `manage`. SIGHUP (`systemctl [--user] reload homebot`) does the former.
"""
    set_door_command(parser, partial(_change, RELOAD), examples)
    parser.add_argument("--allow-removal", action="store_true", help="drop what the file lacks, as after a restart")


def _change(service: str, door: DoorClient, options: argparse.Namespace) -> int:
    is_all = service == RELOAD
    request = {"allow_removal": options.allow_removal} if is_all else {"app": _absolute(options.app)}
    answer = door.call(service, request, timeout=_MAX_WAIT_S)
    text = printable(str(answer["message"]), 2000)
    if not answer["success"]:
        raise PeerError(text)
    print(text)
    return 0


def _absolute(app: str) -> str:
    """Return *app* with the absolute path of its file, for the other program."""
    file, colon, kind = app.partition(":")
    return f"{Path(file).resolve()}{colon}{kind}" if file.endswith(".py") else app


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    answer = cast("AppsResponse", JsonMessage(door.call(LIST_APPS, {})))
    apps = answer.apps
    if options.json:
        print(list_text([json_text(_json(app)) for app in apps]))
    elif apps:
        now, zone = house_time(door), zone_of(answer.zone)
        print_table(("APP", "STATE", "JOB", "NEXT", ""), [row for app in apps for row in _rows(app, now, zone)])
    else:
        print("no app is running")
    return 0


def _rows(app: AppInfo, now: float, zone: tzinfo) -> list[tuple[str, ...]]:
    times = "crashed once" if app.crashes == 1 else f"crashed {app.crashes} times"
    crashes = f", {times}: {printable(app.last_crash, 60)}" if app.crashes else ""
    head = (printable(app.name), f"{app.state}{crashes}")
    jobs = [(_job_text(job), *_times(job, now, zone)) for job in app.jobs] or [("", "", "")]
    return [(*(head if number == 0 else ("", "")), *job) for number, job in enumerate(jobs)]


def _job_text(job: AppJob) -> str:
    return printable(job.name if job.text in job.name else f"{job.name} ({job.text})", 80)


def _times(job: AppJob, now: float, zone: tzinfo) -> tuple[str, str]:
    notes = [printable(job.note, 200)] if job.note else []
    if job.running_since.sec:
        notes.append(f"running since {local_text(job.running_since, zone)}")
    if job.dropped:
        notes.append(f"{job.dropped} calls dropped")
    return next_text(job.next, now, zone), "; ".join(notes)


def _json(app: AppInfo) -> dict[str, object]:
    jobs = [
        {
            "name": job.name,
            "text": job.text,
            "next": iso(job.next) if job.next.sec else None,
            "running_since": iso(job.running_since) if job.running_since.sec else None,
            "dropped": job.dropped,
            "note": job.note,
        }
        for job in app.jobs
    ]
    facts = {"name": app.name, "state": app.state, "crashes": app.crashes, "last_crash": app.last_crash}
    return {**facts, "jobs": jobs}
