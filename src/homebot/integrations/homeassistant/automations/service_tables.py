"""Tables of the services of Home Assistant: their words, fields and values. Pure."""

from collections.abc import Mapping
from typing import Final, NamedTuple

SWITCHED: Final = ("light", "switch", "input_boolean", "fan", "siren", "humidifier", "media_player", "climate")
"""The domains of entities that services of ``homeassistant`` switch in a place."""

_ON_OFF: Final = (*SWITCHED[:-1], "homeassistant")

SERVICE_WORDS: Final = {
    **{f"{domain}.turn_on": "on_off on" for domain in _ON_OFF},
    **{f"{domain}.turn_off": "on_off off" for domain in _ON_OFF},
    **{f"{domain}.toggle": "on_off toggle" for domain in _ON_OFF},
    **{
        f"alarm_control_panel.alarm_arm_{mode}": f"alarm alarm armed_{mode}"
        for mode in ("home", "away", "night", "vacation")
    },
    "alarm_control_panel.alarm_disarm": "alarm disarm",
    "cover.open_cover": "movement|position open",
    "cover.close_cover": "movement|position close",
    "cover.stop_cover": "movement stop",
    "cover.open_cover_tilt": "tilt tilt 100 %",
    "cover.close_cover_tilt": "tilt tilt 0 %",
    "valve.open_valve": "valve|position open",
    "valve.close_valve": "valve|position close",
    "valve.stop_valve": "valve stop",
    "lock.lock": "lock lock",
    "lock.unlock": "lock unlock",
    "lock.open": "lock open",
    "climate.turn_off": "thermostat_mode thermostat_mode off",
    "water_heater.turn_on": "on_off on",
    "water_heater.turn_off": "on_off off",
    "lawn_mower.start_mowing": "mower start",
    "lawn_mower.pause": "mower pause",
    "lawn_mower.dock": "mower dock",
    "media_player.media_play": "playback playback playing",
    "media_player.media_pause": "playback playback paused",
    "media_player.media_stop": "playback playback stopped",
    "media_player.volume_up": "volume volume +10 %",
    "media_player.volume_down": "volume volume -10 %",
    "vacuum.start": "vacuum start",
    "vacuum.pause": "vacuum pause",
    "vacuum.return_to_base": "vacuum dock",
    "vacuum.stop": "vacuum stop",
    "vacuum.clean_spot": "vacuum vacuum spot",
    "scene.turn_on": "scene press",
    "button.press": "push press",
    "input_button.press": "push press",
    "counter.increment": "number number +1",
    "counter.decrement": "number number -1",
    "counter.reset": "number number 0",
    "timer.start": "on_off on",
    "timer.cancel": "on_off off",
    "input_number.increment": "number number +1",
    "input_number.decrement": "number number -1",
}
"""The capability of services without data, of which a device takes the first that it has, and the words."""

SERVICE_FIELDS: Final = {
    "light.turn_on": (
        *("brightness_pct", "brightness", "brightness_step_pct", "brightness_step"),
        *("color_temp_kelvin", "kelvin", "color_temp", "effect"),
    ),
    "cover.set_cover_position": ("position",),
    "cover.set_cover_tilt_position": ("tilt_position",),
    "fan.turn_on": ("percentage",),
    "fan.set_percentage": ("percentage",),
    "fan.set_preset_mode": ("preset_mode",),
    "fan.set_direction": ("direction",),
    "fan.oscillate": ("oscillating",),
    "valve.set_valve_position": ("position",),
    "humidifier.set_mode": ("mode",),
    "water_heater.set_temperature": ("temperature",),
    "water_heater.set_operation_mode": ("operation_mode",),
    "climate.set_fan_mode": ("fan_mode",),
    "climate.set_swing_mode": ("swing_mode",),
    "vacuum.set_fan_speed": ("fan_speed",),
    "media_player.select_source": ("source",),
    "number.set_value": ("value",),
    "input_number.set_value": ("value",),
    "counter.set_value": ("value",),
    "input_text.set_value": ("value",),
    "input_datetime.set_datetime": ("time", "datetime", "timestamp"),
    "humidifier.set_humidity": ("humidity",),
    "climate.set_temperature": ("hvac_mode", "temperature"),
    "climate.set_hvac_mode": ("hvac_mode",),
    "climate.set_preset_mode": ("preset_mode",),
    "media_player.volume_set": ("volume_level",),
    "media_player.volume_mute": ("is_volume_muted",),
    "select.select_option": ("option",),
    "input_select.select_option": ("option",),
}
"""The fields of the data of services; without words one of them is needed."""

SERVICES: Final = SERVICE_WORDS.keys() | SERVICE_FIELDS.keys()


class ServiceSetting(NamedTuple):
    """A value of a service.

    Attributes:
        capabilities: Those that it may be: a device takes only one, or the first of ``a|b`` that it takes.
        words: Those of the command, with the capability and the value.
        factor: What the number in the field is multiplied by.
        of: The only entity that takes it, as it changes its value; empty for any.
    """

    capabilities: str
    words: str = "{name} {value}"
    factor: float = 1.0
    value: str | float = ""
    of: str = ""


SETTINGS: Final = {
    "brightness_pct": ServiceSetting("level", "{value} %"),
    "brightness": ServiceSetting("level", "{value} %", 100 / 255),
    "brightness_step_pct": ServiceSetting("level", "{value} %"),
    "brightness_step": ServiceSetting("level", "{value} %", 100 / 255),
    "tilt_position": ServiceSetting("tilt", "{name} {value} %"),
    "value": ServiceSetting("number", "{name} {value}"),
    "is_volume_muted": ServiceSetting("muted"),
    "color_temp_kelvin": ServiceSetting("color_temperature", "{value} K"),
    "kelvin": ServiceSetting("color_temperature", "{value} K"),
    "color_temp": ServiceSetting("color_temperature", "{value} K"),
    "position": ServiceSetting("position", "{value} %"),
    "percentage": ServiceSetting("fan_speed", "{name} {value} %"),
    "humidity": ServiceSetting("humidity_setpoint"),
    "temperature": ServiceSetting("heating_setpoint cooling_setpoint"),
    "volume_level": ServiceSetting("volume", "{name} {value} %", 100.0),
    "hvac_mode": ServiceSetting("thermostat_mode"),
    "preset_mode": ServiceSetting("preset_mode"),
    "option": ServiceSetting("option"),
    "source": ServiceSetting("option"),
    "effect": ServiceSetting("effect"),
    "direction": ServiceSetting("direction"),
    "oscillating": ServiceSetting("oscillation"),
    "text": ServiceSetting("text", "{value}"),
    "time": ServiceSetting("text", "{value}"),
    "datetime": ServiceSetting("text", "{value}"),
    "timestamp": ServiceSetting("text", "{value}"),
    "mode": ServiceSetting("humidifier_mode"),
    "operation_mode": ServiceSetting("water_heater_mode"),
    "fan_mode": ServiceSetting("fan_mode"),
    "fan_speed": ServiceSetting("fan_mode"),
    "swing_mode": ServiceSetting("swing_mode"),
}

DROPPED: Final = {
    *("camera.snapshot", "camera.record", "logbook.log", "persistent_notification.dismiss", "system_log.write"),
    *("logger.set_level", "homeassistant.update_entity", "frontend.set_theme", "browser_mod.popup"),
}
"""Services without an effect in the house."""

LEFT_OUT: Final = {"siren.turn_on": ("tone", "volume_level")}
"""Fields of services without which they do nearly the same."""

DEVICE_DATA: Final = frozenset({"brightness_pct", "position", "hvac_mode", "preset_mode", "option", "value"})
"""The fields of actions of devices that are data."""

DEVICE_ACTIONS: Final[Mapping[str, tuple[str, Mapping[str, object]]]] = {
    "light.brightness_increase": ("light.turn_on", {"brightness_step_pct": 10}),
    "light.brightness_decrease": ("light.turn_on", {"brightness_step_pct": -10}),
    "light.flash": ("light.turn_on", {"flash": "short"}),
    "cover.open": ("cover.open_cover", {}),
    "cover.close": ("cover.close_cover", {}),
    "cover.stop": ("cover.stop_cover", {}),
    "cover.set_position": ("cover.set_cover_position", {}),
    "vacuum.clean": ("vacuum.start", {}),
    "vacuum.dock": ("vacuum.return_to_base", {}),
}
"""The services of actions of devices that are called otherwise, with their fields."""

ADVICE: Final = {
    "camera": "; homebot sends no pictures: leave it out",
    "cover": "; write `open`, `close` or `stop`",
    "mqtt": "; command the device itself, or write an app, see docs/apps.md",
    "pyscript": "; write an app, see docs/apps.md",
    "python_script": "; write an app, see docs/apps.md",
    "remote": "; command the device itself",
    "scene": "; write the scene in homebot, see docs/scenes.md",
    "todo": "; send a message by `notify` instead",
    "weather": "; use a sensor of the forecast",
    "media_player": "; write `media` and an address, or its source",
    "shell_command": "; write an app, see docs/apps.md",
    "rest_command": "; write an app, see docs/apps.md",
    "script": "; write the routine of its steps, or import it from the file with `script:`",
    "climate": "; write the mode, as `climate.set_hvac_mode`",
}
