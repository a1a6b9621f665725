"""What the figures were measured on."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib.metadata import version

__all__ = ["describe_machine"]

PACKAGES = ("homebot", "pydantic", "anyio", "aiomqtt", "paho-mqtt", "structlog", "websockets")


def describe_machine(home_assistant: str | None, mosquitto: str | None) -> str:
    parts = [
        f"{os.cpu_count()} CPUs, load {os.getloadavg()[0]:.1f}",
        f"{platform.system()} {platform.release()} {platform.machine()}",
        f"Python {platform.python_version()}",
        ", ".join(f"{package} {version(package)}" for package in PACKAGES),
    ]
    if home_assistant:
        parts.append(f"Home Assistant {home_assistant}")
    if mosquitto:
        parts.append(_mosquitto_version(mosquitto))
    return "; ".join(parts)


def _mosquitto_version(program: str) -> str:
    lines = subprocess.run([program, "-h"], capture_output=True, text=True, check=False).stdout.splitlines()
    return lines[0] if lines else "mosquitto"
