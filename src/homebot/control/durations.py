"""Durations of the control layer, in seconds, each with its reason. Pure.

The devices behind them are in public reports: REPOSITORY#NUMBER is an issue on GitHub.
"""

from typing import Final

SAME_MESSAGE: Final = 0.01
"""Reports within this time belong to one message, by one or several routes."""

SENT_AT_ONCE: Final = 0.01
"""A connected gateway sends within this time."""

ACKNOWLEDGED_TOO: Final = 1.0
"""A gateway that is about to return has this long after the outcome; what it still does then is cancelled."""

OVERTAKEN: Final = 0.2
"""A raw command of another program may be known this much later than its effect if the event loop is busy."""

FAST: Final = 0.1
"""A report this soon after a sending may be a bridge's echo: radios take longer.

Zigbee2MQTT publishes the wanted brightness at once, then the lamp's own (Koenkk/zigbee2mqtt#3949).
"""

LEVEL_FOLLOWS: Final = 1.0
"""A lamp that reports "on" reports its level within this time, in the next message at the latest."""

LAST_STEPS: Final = 2.0
"""The last steps of a transition may be reported this long after its end.

Philips Hue reports steps even without a transition (Koenkk/zigbee2mqtt#32050).
"""

CAME_ALONG: Final = 3.0
"""What changes this soon after a sign of a command may belong to it: other values of the part, and parts near it.

The lamps of a Zigbee group report up to 2 s later (Koenkk/zigbee2mqtt#764).
"""

UNREAD: Final = 10.0
"""A raw text of unknown meaning explains what its device reports for so long: as a command settles by default."""

TAKEN_BACK: Final = 3.0
"""A bridge retracts its echo within this time if the device refused or another value is read back.

deCONZ shows 255 for an Elko RF dimmer that ignored it, until it polls (dresden-elektronik/deconz-rest-plugin#1594).
"""

REGULAR: Final = 0.5
"""Returns that differ by no more than this come from a timer in the device or bridge, rather than from people."""

ECHO_PATIENCE: Final = 2.0
"""A device's own report follows its first echoes within this time, or never."""

FADE_SILENCE: Final = 6.0
"""A dimmer that is silent for this long on its ramp is stuck: most report at least each second."""

STOPPED: Final = 10.0
"""A motor that stopped on its way moves on, or reports its position, within this time."""

SUPERSEDED: Final = 10.0
"""A command may still have an effect this long after a newer one replaced it."""

MOTOR_SILENCE: Final = 60.0
"""A motor may report nothing for a whole run: blinds take up to a minute.

Others report each second, as Tuya's _TZE200_xuzcvlku (Koenkk/zigbee2mqtt#12679).
"""

LATE: Final = 60.0
"""A device may answer this long after its command failed; later a person is likelier, unless it is the exact value."""

ASLEEP: Final = 900.0
"""A device that sleeps answers with the exact value, this long after a command without an answer at most.

A Danfoss valve with Z-Wave wakes every five minutes (OpenZWave/Zwave2Mqtt#228).
"""

HASTY: Final = 15.0
"""People undo a command within this time so often that two of them coincide by chance."""

CREEPS: Final = 20.0
"""Adaptive lighting changes a lamp a little at intervals longer than this; steps of one change come sooner.

Home Assistant's Adaptive Lighting does so each 90 s by default (basnijholt/adaptive-lighting, ``interval``).
"""

PUNCTUAL: Final = 2.0
"""Times of a program's schedule differ by less, those of people by more."""

INTERVAL: Final = 3600.0
"""Programs switch at shorter intervals than this; who does so at the same time each day may be a person.

A setpoint that changes at the same second each day is the schedule of a thermostat.
"""

CLOCK_DRIFT: Final = 0.001
"""The fraction by which the times of a timer in a device may differ, beyond :data:`REGULAR`."""

FRESH: Final = 60.0
"""For this long a live report counts as the present state: a command for the same value is not sent."""

WISH: Final = 60.0
"""An app responds to a press, a scan or a call within this time; a later command is its own decision."""

MAX_MOVE: Final = 300.0
"""The longest wait for a motor: gates take up to two minutes."""

REMEMBERED: Final = 900.0
"""The facts of a part are stored for this long, plus one older change for the presence guard."""

FORGOTTEN_EVERY: Final = 300.0
"""Ended durations are forgotten this often: most parts get no further command or report for hours."""

COUNTED: Final = 3600.0
"""The sendings to a part are stored for this long, which is the longest time of a rate limit."""

REHEARSED: Final = 0.1
"""The response time of a device in a rehearsal, so that an app that repeats commands does not block."""

MIN_ANSWER: Final = 2.0
MAX_ANSWER: Final = 120.0
"""Bounds of the time that a device has to answer."""

ANSWER_SPARE: Final = 1.0
ANSWER_FACTOR: Final = 3.0
"""A device has three times its longest known response time, plus a second."""

UNKNOWN_ANSWER: Final = 1.0
"""The longest response time counts as at least this if fewer than three are known."""

BETWEEN_SENDINGS: Final = 1.5
"""Networks expire commands after whole seconds, so the next sending waits this much longer."""
