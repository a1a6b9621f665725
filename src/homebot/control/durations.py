"""Durations of the control layer, in seconds, each with its reason. Pure.

The devices that need them are those of public reports: REPOSITORY#NUMBER is an issue on GitHub.
"""

from typing import Final

SAME_MESSAGE: Final = 0.01
"""Reports within it belong to one message, by one or by several routes."""

SENT_AT_ONCE: Final = 0.01
"""A gateway with a connection needs no longer to send."""

FAST: Final = 0.1
"""A report this soon after sending may be a bridge's echo: radios take longer.

Zigbee2MQTT publishes the wanted brightness at once, then the lamp's own (Koenkk/zigbee2mqtt#3949).
"""

LEVEL_FOLLOWS: Final = 1.0
"""A lamp that reports "on" reports its level within it, in a second message at most."""

LAST_STEPS: Final = 2.0
"""The last steps of a transition may be reported this long after its end.

Philips Hue reports steps also without one (Koenkk/zigbee2mqtt#32050).
"""

CAME_ALONG: Final = 3.0
"""Other values of the part that change this soon after a sign of a command belong to it."""

TAKEN_BACK: Final = 3.0
"""A bridge that was refused, or reads the device back, takes its echo back within it.

deCONZ shows 255 for an Elko RF dimmer that ignored it, until it asks (dresden-elektronik/deconz-rest-plugin#1594).
"""

REGULAR: Final = 0.5
"""Returns that differ by no more come from a timer in the device or bridge, rather than from persons.

Shelly relays have one: ``auto_off_delay`` (Shelly API, Gen2+, Switch).
"""

ECHO_PATIENCE: Final = 2.0
"""The first echoes of a device are followed by its own report within it, or never."""

FADE_SILENCE: Final = 6.0
"""A dimmer that is silent for so long on its ramp is stuck: most report at least each second."""

STOPPED: Final = 10.0
"""A motor that stopped on its way goes on, or reports its position, within it."""

SUPERSEDED: Final = 10.0
"""A command may still have an effect this long after a newer one replaced it."""

MOTOR_SILENCE: Final = 60.0
"""A motor may report nothing for a whole run: blinds take up to a minute.

Others report each second, as Tuya's _TZE200_xuzcvlku (Koenkk/zigbee2mqtt#12679).
"""

LATE: Final = 60.0
"""A device may answer this long after its command failed; later a person is likelier."""

FRESH: Final = 60.0
"""A live report is the present state for so long, so that a command for the same value is not sent."""

WISH: Final = 60.0
"""An app answers a press, a scan or a call within it; a later command is its own decision."""

LONGEST_MOVE: Final = 300.0
"""No motor is waited for any longer: gates take up to two minutes."""

REMEMBERED: Final = 900.0
"""Facts of a part are stored for so long; for the presence guard one older change is stored as well."""

FIRST_REPORTS: Final = 600.0
"""A device that begins to report has reported each of its values within it."""

REHEARSED: Final = 0.1
"""A device answers a rehearsed command after it, so that an app that repeats commands does not block."""

SHORTEST_ANSWER: Final = 2.0
LONGEST_ANSWER: Final = 120.0
"""Bounds of the time that a device gets for its answer."""

ANSWER_SPARE: Final = 1.0
ANSWER_FACTOR: Final = 3.0
"""A device gets three times its longest known answer, and a second more."""

UNKNOWN_ANSWER: Final = 1.0
"""Of a device with fewer than three known answers, the longest counts as this at least."""

BETWEEN_SENDINGS: Final = 1.5
"""Networks count whole seconds until they forget a command, so that the next sending waits so much longer."""
