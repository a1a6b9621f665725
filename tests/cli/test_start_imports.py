"""A start loads what it needs, and nothing for what may come."""

import subprocess
import sys
from pathlib import Path

_MOST_MODULES = 341
"""Modules of homebot; of more each should be needed before a start is done."""

IDLE = """
import anyio
from homebot import App

class Idle(App):
    async def run(self):
        await anyio.sleep_forever()
"""

NOT_NEEDED = (
    "aiomqtt",
    "difflib",
    "jinja2",
    "paho",
    "platformdirs",
    "rich",
    "shtab",
    "sqlite3",
    "tomllib",
    "twisted",
    "zenoh",
    "homebot.bridges.zenoh",
    "homebot.features.machine.serving",
    "homebot.features.ros2.link",
    "homebot.bridges.rosbridge.protocol",
    "homebot.bridges.rosbridge.session",
    "homebot.cli.yaml",
    "homebot.control.executor",
    "homebot.control.journal.journal",
    "homebot.control.policies",
    "homebot.control.settings",
    "homebot.integrations.homeassistant.formats.publisher",
    "homebot.integrations.homeassistant.formats.reader",
    "homebot.integrations.homie.formats.reader",
    "homebot.integrations.homeassistant.formats.jinja",
    "homebot.integrations.shelly.formats.reader",
    "homebot.conventions.table_codec",
    "homebot.integrations.tasmota.formats.reader",
    "homebot.conventions.units",
    "homebot.integrations.zigbee2mqtt.formats.reader",
    "homebot.devices.handles.appliances",
    "homebot.devices.misspelt_names",
    "homebot.devices.outcomes",
    "homebot.words.queries",
    "homebot.devices.robot_owners",
    "homebot.devices.near_watch",
    "homebot.discovery.nearness",
    "homebot.places.path",
    "homebot.discovery.store",
    "homebot.gateways.mqtt.unread_topics",
    "homebot.house.description",
    "homebot.house.kinds",
    "homebot.house.robot",
    "homebot.messages.geometry_msgs",
    "homebot.messages.interfaces",
    "homebot.messages.std_msgs",
    "homebot.mqtt.broker.tls_socket",
    "homebot.mqtt.certificate",
    "homebot.mqtt.client.aiomqtt_adapter",
    "homebot.recording",
    "homebot.replay",
    "homebot.testing",
    "homebot.support.virtual_time",
    "homebot.integrations.things.formats.mqtt.reader",
    "homebot.integrations.things.formats.parse",
    "homebot.robots",
)


def test_a_start_loads_no_more_than_it_needs(tmp_path: Path) -> None:
    """A convention's reader waits for a message, a parser for a text, a session for a client, SQLite for a file.

    What commands, policies and the journal need waits for a command: the app gives none.
    """
    (tmp_path / "idle.py").write_text(IDLE)
    code = (
        "import sys\nfrom homebot.cli import main\n"
        "assert main(['run', '--app', 'idle:Idle', '--door', '127.0.0.1:0', '--for', '0.1']) == 0\n"
        "print(*sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120, cwd=tmp_path
    )
    loaded = done.stdout.split()
    assert [one for one in loaded if one in NOT_NEEDED] == []
    assert "home425 is running" in done.stderr
    assert len([one for one in loaded if one.startswith("homebot")]) <= _MOST_MODULES


def test_commands_of_a_client_start_without_pydantic() -> None:
    """It takes longer to import than such a command to run."""
    names = (
        "devices",
        "do",
        "doctor",
        "find",
        "journal",
        "leases",
        "node",
        "places",
        "service",
        "show",
        "tag",
        "topic",
    )
    modules = [f"homebot.cli.commands.{name}" for name in names]
    modules += [f"homebot.features.{name}.command" for name in ("bags", "goals", "history")]
    code = f"import sys, {', '.join(modules)}\nprint('pydantic' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    assert done.stdout == "False\n"
