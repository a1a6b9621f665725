"""Damaged announcements and messages of ``tasmota``: refused in our words, or understood."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from homebot.conventions.tasmota import TasmotaDiscovery, TasmotaSettings

if TYPE_CHECKING:
    from tests.fuzz.conftest import Fuzz


def test_damaged_devices_are_refused_or_read(fuzz: Fuzz, devices: Callable[[str], list[dict[str, Any]]]) -> None:
    fuzz.convention("tasmota", lambda: TasmotaDiscovery(TasmotaSettings()), devices("tasmota"))
