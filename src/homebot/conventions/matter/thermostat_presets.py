"""The presets of a thermostat, such as *Home* and *Away*: temperatures that it keeps by name. Pure.

Source: Matter 1.4 Application Clusters, 4.3.9 (Presets).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from homebot.conventions.command_values import require_option
from homebot.conventions.matter.endpoint import ClusterInvocation, MatterAbility, MatterEndpoint, MatterOrder
from homebot.conventions.payload import text_of
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue

__all__ = ["preset_abilities"]

THERMOSTAT: Final = 513
_HAS_PRESETS: Final = 1 << 8
_ACTIVE, _PRESETS = 0x4E, 0x50
_SCENARIOS: Final = {1: "occupied", 2: "unoccupied", 3: "sleep", 4: "wake", 5: "vacation", 6: "going_to_sleep"}
_MOST: Final = 50
_LONGEST_HANDLE: Final = 64


def preset_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    """Yield the preset, where there are some to choose from."""
    names = tuple(_presets(endpoint))
    if names and endpoint.features(THERMOSTAT) & _HAS_PRESETS:
        capability = Capability(name="preset_mode", settable=True, options=names)
        yield MatterAbility(THERMOSTAT, capability, _read_preset, _write_preset)


def _presets(endpoint: MatterEndpoint) -> dict[str, str]:
    """Return the handles of the presets, in Base64 as the server has bytes, by their names."""
    found: dict[str, str] = {}
    for one in endpoint.structs(THERMOSTAT, _PRESETS):
        handle, scenario = one.get("0", one.get("presetHandle")), one.get("1", one.get("presetScenario"))
        said = one.get("2", one.get("name"))
        name = text_of(said)
        name = name or (_SCENARIOS.get(scenario, "") if isinstance(scenario, int) else "")
        if name and isinstance(handle, str) and 0 < len(handle) <= _LONGEST_HANDLE and len(found) < _MOST:
            found.setdefault(name, handle)
    return found


def _read_preset(endpoint: MatterEndpoint) -> PlainValue:
    active = endpoint.value(THERMOSTAT, _ACTIVE)
    return next((name for name, handle in _presets(endpoint).items() if handle == active), None)


def _write_preset(
    endpoint: MatterEndpoint, value: PlainValue, _transition: float, _code: str
) -> tuple[MatterOrder, ...]:
    presets = _presets(endpoint)
    handle = presets[require_option("preset_mode", value, presets)]
    return (ClusterInvocation(THERMOSTAT, "SetActivePresetRequest", {"presetHandle": handle}),)
