"""Devices that hang on an alarm panel: a switch there may bypass a zone. Pure.

Devices that announce themselves, or whose bridge does, hang on none: otherwise a stranger's panel with the identifier
of Zigbee2MQTT would make all its switches ask.
"""

from collections.abc import Container
from typing import Final

from homebot.devices.identity import identifiers
from homebot.discovery.device_table import DeviceTable
from homebot.discovery.entry import Entry
from homebot.discovery.topics.use import bridge_of

_MOST: Final = 1000
"""Identifiers of alarm panels; those of further panels do not count."""


def find_panel(table: DeviceTable, entry: Entry) -> None:
    """Record the alarm panel on which *entry* hangs, and if it is a new panel itself, which devices hang on it."""
    if table.panels:
        entry.panel = _panel_of(entry, table.panels)
    sightings = [source.sighting for source in entry.sources.values()]
    panels = [one for one in sightings if any(part.service_type == "x_alarm_panel" for part in one.parts)]
    new = {name for one in panels for name in one.identifiers} - table.panels
    if not new or len(table.panels) >= _MOST:
        return
    table.panels |= new
    _hang_others(table, entry, new)


def _hang_others(table: DeviceTable, entry: Entry, new: Container[str]) -> None:
    for other in table.entries.values():
        if other is not entry and (panel := _panel_of(other, new)):
            other.invalidate_description()
            other.panel = panel
            table.record_change("changed", other, f"it hangs on the alarm panel {entry.id}")


def _panel_of(entry: Entry, panels: Container[str]) -> str:
    """Return the identifier among *panels* behind which *entry* is announced; empty if there is none."""
    if any(source.sighting.native for source in entry.sources.values()):
        return ""
    bridges = identifiers(bridge_of(source.sighting) for source in entry.sources.values())
    return next((one for one in bridges if one in panels), "")
