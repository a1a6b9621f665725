"""The services that only report: sensors, batteries and buttons. Pure.

Source: HomeKit Accessory Protocol Specification R2, 8.3 (Air Quality Sensor), 8.5 (Battery), 8.37 (Stateless
Programmable Switch), and the other sensors of chapter 8.
"""

from __future__ import annotations

from typing import Final

from homebot.conventions.homekit.rows import ServiceRow

__all__ = ["PRESS", "PRESSES", "SENSOR_ROWS"]

AIR, MOTION, OCCUPANCY, CONTACT, LEAK, SMOKE = "8D", "85", "86", "80", "83", "87"
MONOXIDE, DIOXIDE, BATTERY = "7F", "97", "96"
PRESS: Final = "73"
"""The characteristic Programmable Switch Event."""

PRESSES: Final = {0: "single", 1: "double", 2: "long"}
_SENSORS: Final = f"{AIR} {MOTION} {OCCUPANCY} {CONTACT} {LEAK} {SMOKE} {MONOXIDE} {DIOXIDE} 8A 82 84"

SENSOR_ROWS: Final = (
    ServiceRow("89 121", "press", PRESS, "", PRESSES),  # buttons and doorbells
    ServiceRow(MOTION, "occupancy", "22"),
    ServiceRow(OCCUPANCY, "occupancy", "71"),
    ServiceRow(CONTACT, "contact", "6A"),  # 1 is "not detected": open
    ServiceRow(LEAK, "water_leak", "70"),
    ServiceRow(SMOKE, "smoke", "76"),
    ServiceRow(MONOXIDE, "carbon_monoxide_alarm", "69"),
    ServiceRow(f"{MONOXIDE} {AIR}", "carbon_monoxide", "90"),
    ServiceRow(DIOXIDE, "safety", "92"),
    ServiceRow(f"{DIOXIDE} {AIR}", "carbon_dioxide", "93"),
    ServiceRow(AIR, "air_quality_index", "95"),  # 0 is unknown, 1 is excellent, 5 is poor
    ServiceRow(AIR, "pm25", "C6"),
    ServiceRow(AIR, "pm10", "C7"),
    ServiceRow(AIR, "volatile_organic_compounds", "C8"),
    ServiceRow("8A", "temperature", "11"),
    ServiceRow("82", "humidity", "10"),
    ServiceRow("84", "illuminance", "6B"),
    ServiceRow(BATTERY, "battery", "68"),
    ServiceRow(
        BATTERY, "battery_charging", "8F", read=lambda service: service.number("8F") == 1
    ),  # 2 is "not chargeable"
    ServiceRow(f"{BATTERY} {_SENSORS}", "battery_low", "79"),
    ServiceRow(_SENSORS, "tamper", "7A"),
    ServiceRow(_SENSORS, "problem", "77"),
)
