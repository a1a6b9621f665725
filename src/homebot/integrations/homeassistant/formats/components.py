"""The components of configs that are understood, and the actions of those that move or lock, by their state. Pure.

Source of the actions: Home Assistant core 2026.11, ``components``: ``const.py`` of lawn_mower, lock and vacuum.
"""

from collections.abc import Mapping

BUILDERS: Mapping[str, tuple[str, str]] = {
    "alarm_control_panel": ("locks", "build_alarm_control_panel"),
    "binary_sensor": ("sensors", "build_binary_sensor"),
    "button": ("settings", "build_button"),
    "camera": ("sensors", "build_camera"),
    "climate": ("climate", "build_climate"),
    "cover": ("openings", "build_cover"),
    "date": ("settings", "build_moment"),
    "datetime": ("settings", "build_moment"),
    "device_automation": ("sensors", "build_trigger"),
    "device_tracker": ("sensors", "build_device_tracker"),
    "event": ("sensors", "build_event"),
    "fan": ("appliances", "build_fan"),
    "humidifier": ("appliances", "build_humidifier"),
    "image": ("sensors", "build_image"),
    "lawn_mower": ("appliances", "build_lawn_mower"),
    "light": ("light", "build_light"),
    "lock": ("locks", "build_lock"),
    "notify": ("settings", "build_notify"),
    "number": ("settings", "build_number"),
    "scene": ("settings", "build_scene"),
    "select": ("settings", "build_select"),
    "sensor": ("sensors", "build_sensor"),
    "siren": ("appliances", "build_siren"),
    "switch": ("settings", "build_switch"),
    "tag": ("sensors", "build_tag"),
    "text": ("settings", "build_text"),
    "time": ("settings", "build_moment"),
    "update": ("sensors", "build_update"),
    "vacuum": ("appliances", "build_vacuum"),
    "valve": ("openings", "build_valve"),
    "water_heater": ("climate", "build_water_heater"),
}
"""Module and builder by component, each proven by lines of ``components.jsonl`` in the tests.

No builder reads a meaning from a name or an id: parts that differ in these alone are built once.
Other components are ignored without a log line.
"""

_SECONDARY = frozenset({"binary_sensor", "button", "number", "select", "sensor", "text"})

COMPONENTS = ("device", *sorted(BUILDERS, key=_SECONDARY.__contains__))
"""Components of configs: a whole device, or those with a builder.

The secondary ones are read last: their configs often have only the identifiers of the device, such as those of Nuki
Hub, and the id of a device is made of its name when it is found.
"""

LOCK_STATES = ("unlocked", "locked", "unlocking", "open", "locking", "opening", "jammed")

MOWER_ACTIONS: Mapping[str, tuple[int, str]] = {
    "mowing": (1, "start_mowing"),
    "paused": (2, "pause"),
    "docked": (4, "dock"),
    "idle": (8, "stop"),
}
"""The bit of ``supported_features`` that each needs, and its name."""

MOWER_STATES = (*MOWER_ACTIONS, "returning", "error")

VACUUM_ACTIONS: Mapping[str, tuple[int, str]] = {
    "cleaning": (8192, "start"),
    "paused": (4, "pause"),
    "idle": (8, "stop"),
    "returning": (16, "return_to_base"),
    "spot": (1024, "clean_spot"),
}
"""As :data:`MOWER_ACTIONS`."""

VACUUM_STATES = ("cleaning", "docked", "paused", "idle", "returning", "error")
