"""Random devices: the settings of each kind and fault, in plain numbers; the simplest has none."""

from collections.abc import Collection, Mapping, Sequence
from typing import Final

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from homebot.config import Table
from homebot.testing.strategies.choices import Settings, one_of, optional

MAX_FAULTS = 2
"""Faults that one device has at most: each wraps the others, and two show how they meet."""

NONSENSE: Final = "nonsense"
"""A command that no device knows."""

PAYLOADS: Final[Mapping[str, Sequence[str]]] = {
    "lamp": ("on", "off", "0.5", "2700 K"),
    "window": ("open", "close", "stop", "0.5"),
    "cover": ("open", "close", "stop", "0.5"),
    "lock": ("lock", "unlock"),
    "contact": (),
    "motion": (),
    "presence": (),
    "lux": (),
    "power_meter": (),
    "thermostat": ("20", "5", "30"),
    "robot": ("go outside", "stop"),
    "lift": ("upper", "open", "close", "ground"),
}
"""The commands of each kind of device."""

_switch = st.booleans()
_share = st.integers(0, 10).map(lambda tenths: tenths / 10)
_watts = st.sampled_from((10.0, 1.0, 60.0, 2000.0))
_seconds = st.sampled_from((10.0, 1.0, 60.0, 600.0, 3600.0))
_motor: Settings = {"is_open": _switch, "travel_time": _seconds}

KIND_SETTINGS: Final[Mapping[str, Settings]] = {
    "lamp": {
        "is_on": _switch,
        "brightness": _share,
        "kelvin": st.sampled_from((2700.0, 1500.0, 6500.0)),
        "rated_watts": _watts,
        "rated_lux": st.sampled_from((100.0, 0.0, 1000.0)),
    },
    "window": _motor,
    "cover": _motor,
    "lock": {"is_locked": _switch, "travel_time": _seconds, "jams": _share},
    "contact": {},
    "motion": {"hold": _seconds},
    "presence": {"hold": _seconds},
    "lux": {"share": _share},
    "power_meter": {"step": _watts},
    "thermostat": {
        "celsius": st.integers(-10, 35).map(float),
        "target": st.integers(5, 30).map(float),
        "gain": st.sampled_from((100.0, 0.0, 1000.0)),
        "inertia": st.sampled_from((10_000.0, 1000.0, 100_000.0)),
        "rated_watts": _watts,
    },
    "robot": {"speed": st.sampled_from((1.0, 0.1, 10.0))},
    "lift": {
        "floors": st.sampled_from((["ground", "upper"], ["cellar", "ground", "upper"])),
        "travel_time": _seconds,
        "door_time": _seconds,
    },
}
"""The settings of each kind of device."""

FAULT_SETTINGS: Final[Mapping[str, Settings]] = {
    "deaf": {},
    "liar": {"since": st.integers(0, 23).map(lambda hour: hour * 3600.0)},
    "echoing_bridge": {},
    "stuck": {"after": st.sampled_from((2.0, 30.0))},
    "slow": {"delay": _seconds},
    "reverter": {"after": _seconds},
    "lossy": {"share": _share},
    "unplugged": {
        "since": st.integers(0, 23).map(lambda hour: hour * 3600.0),
        "until": st.integers(1, 24).map(lambda hour: hour * 3600.0),
    },
    "flapper": {"every": st.sampled_from((3600.0, 60.0, 600.0))},
    "chatterbox": {"times": st.integers(1, 20), "every": st.sampled_from((1.0, 0.1, 10.0))},
    "late": {"delay": _seconds},
    "silent": {"since": st.integers(0, 23).map(lambda hour: hour * 3600.0)},
}
"""The settings of each fault, the quietest fault first."""


@st.composite
def devices(
    draw: DrawFn,
    rooms: tuple[str, ...],
    doors: Collection[tuple[str, str]],
    kinds: tuple[str, ...],
    faults: tuple[str, ...],
) -> Table:
    """Draw random devices, each as its table in the file."""
    kind = draw(one_of(kinds))
    room = draw(one_of(rooms))
    table: Table = {"kind": kind, "room": room}
    if kind in {"contact", "lock"} and draw(_switch):
        table["door"] = draw(one_of(tuple(sorted({end for door in doors if room in door for end in door} - {room}))))
    table |= draw(_KINDS[kind])
    if faults and (wrong := draw(_faulty(faults))):
        table["faults"] = wrong
    return table


def commands(kind: str) -> SearchStrategy[str]:
    """Return a strategy for commands to a device of *kind*, unknown ones as well."""
    likely = PAYLOADS[kind][:2]  # most failures need these
    return one_of((*PAYLOADS[kind], NONSENSE, *likely))


@st.composite
def _faulty(draw: DrawFn, faults: tuple[str, ...]) -> Table:
    table: Table = {}
    while draw(_switch) and len(table) < MAX_FAULTS:
        fault = draw(one_of(faults))
        table[fault] = draw(_FAULTS[fault])
    return table


_KINDS: Final = {kind: optional(settings) for kind, settings in KIND_SETTINGS.items()}
_FAULTS: Final = {fault: optional(settings) for fault, settings in FAULT_SETTINGS.items()}
