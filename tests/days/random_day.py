"""Random days of random houses with random apps and policies. The simplest is an hour in which nothing happens."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy
from tests.days.random_app import RANDOM_APP
from tests.days.random_doors import hands_on_doors, random_doors
from tests.days.random_people import random_people

from homebot.devices.value import PlainValue
from homebot.testing import Day
from homebot.testing.day_event import DayEvent
from homebot.testing.strategies import days, houses

Table = dict[str, Any]

_WALK: Final = 10.0
_LEFT: Final = 80.0
"""Seconds after the start at which somebody walks past all sensors, and has left through all doors."""

_HOURS: Final = st.integers(0, 23).map(lambda hour: hour * 3600.0)
_SENSOR_FAULTS: Final[SearchStrategy[Table]] = st.one_of(
    st.fixed_dictionaries({"stuck": st.just({})}),  # it never detects anybody, or that it is opened
    st.fixed_dictionaries({"silent": st.fixed_dictionaries({"since": _HOURS})}),
    st.fixed_dictionaries({"late": st.fixed_dictionaries({"delay": st.sampled_from((2.0, 60.0, 600.0))})}),
    st.fixed_dictionaries({"flapper": st.fixed_dictionaries({"every": st.sampled_from((3600.0, 60.0))})}),
    st.fixed_dictionaries({"unplugged": st.fixed_dictionaries({"since": _HOURS})}),
)
"""The faults of motion sensors and of contacts on doors and windows, one at a time."""

LAMP_FAULTS: Final = ("deaf", "liar", "slow", "reverter", "lossy", "flapper", "stuck")
_A_LAMP_FAULT: Final[SearchStrategy[Table]] = st.sampled_from(LAMP_FAULTS).map(lambda fault: {fault: {}})
KINDS: Final = ("lamp", "contact", "lux", "cover", "lock", "thermostat")
APPS: Final = ("light_service", "lights_out", "follow_me", "window_heating")

GRANTS: Final[Mapping[str, tuple[str, ...]]] = {
    "lamps_only": ("light",),
    "names_locks": ("light", "door lock"),
    "everything": (),
}
"""The random apps and what they are granted; empty for no table ``act``."""

_ORDERS: Final[Mapping[str, tuple[tuple[str, object, str], ...]]] = {
    "lamp": (("on_off", False, "off"), ("on_off", True, "on"), ("level", 40.0, "0.4"), ("level", 0.0, "0")),
    "cover": (("position", 0.0, "0"), ("position", 100.0, "1"), ("movement", "closed", "close")),
    "lock": (("lock", "unlocked", "unlock"), ("lock", "locked", "lock")),
    "thermostat": (("heating_setpoint", 25.0, "25"), ("heating_setpoint", 8.0, "8")),
}
"""What is commanded of each kind: capability, value, and the same as a text."""


@dataclass(frozen=True)
class RandomDay:
    """A day, with what runs in homebot meanwhile.

    Attributes:
        day: The house and what happens in it.
        control: The table ``[control]``.
        apps: The tables ``[apps]``.
        orders: The commands of a person at a client of the door: seconds after the start, device, capability, value.
        seed: Of what is random on the network.
        rooms: The table ``[places.rooms]``: the rooms, with the doors that the owner states; empty for none.
    """

    day: Day
    control: Table
    apps: Table
    orders: tuple[tuple[float, str, str, PlainValue], ...]
    seed: int
    rooms: Table = field(default_factory=dict)

    @property
    def doors(self) -> Mapping[str, tuple[str, ...]]:
        """The contacts on all doors of each room that the presence guard is told of, by name."""
        guard = self.control.get("presence_guard")
        doors: Table = guard.get("doors", {}) if isinstance(guard, dict) else {}
        return {room: tuple(contacts) for room, contacts in doors.items()}

    @property
    def absent_after(self) -> float:
        """Seconds without motion after which the presence guard takes nobody to be there."""
        guard = self.control.get("presence_guard")
        return float(guard.get("absent_after", 1200.0)) if isinstance(guard, dict) else 1200.0

    @property
    def places(self) -> Table:
        """The table ``[places]``, as an owner would write it: the plan, and devices that announce no room."""
        world = self.day.world()
        return {
            "rooms": self.rooms,
            "devices": {
                f"{placed.device.service_type}/{name}": {"room": placed.room}
                for name, placed in world.devices.items()
                if placed.dialect == "thesis"
            },
        }


@st.composite
def random_days(draw: DrawFn, *, max_length: str = "24h") -> RandomDay:
    """Draw days of at most *max_length*."""
    tables: Table = draw(houses(kinds=KINDS, faults=LAMP_FAULTS, max_devices=4, max_people=0, max_errands=0))
    tables.setdefault("house", {})["dialect"] = draw(st.sampled_from(("thesis", "homeassistant")))
    things = draw(_things(tables["rooms"], tables.get("devices", {})))
    tables["devices"] = things
    doors = draw(random_doors(tables["rooms"], _some(_SENSOR_FAULTS)))
    things.update(doors.contacts)
    day = draw(days(tables, what=("press", "cut", "restart"), max_length=max_length))
    tables["people"] = draw(random_people(tables["rooms"], day.start, day.length))
    kinds = {name: table["kind"] for name, table in things.items()}
    contacts = tuple(name for name, kind in kinds.items() if kind == "contact")
    hands = draw(hands_on_doors(day, contacts))
    if draw(st.integers(0, 3)):  # most homes are lived in: somebody has walked past each sensor, and left
        hands += _walk(day.start, [name for name, kind in kinds.items() if kind == "motion"], tuple(doors.contacts))
    day = replace(day, house=tables, happenings=(*hands, *day.happenings))
    commandable = tuple((name, kind) for name, kind in kinds.items() if kind in _ORDERS)
    apps: Table = {name: {} for name in APPS if draw(st.sampled_from((True, True, False)))}
    if "lights_out" in apps:
        apps["lights_out"] = {"quiet_after": draw(st.sampled_from((600.0, 10.0)))}
    for name, act in GRANTS.items():
        orders = draw(_orders(commandable, day.length))
        if orders:
            apps[name] = {"class": RANDOM_APP, "orders": orders, **({"act": list(act)} if act else {})}
    own = draw(_orders(commandable, day.length))
    person = tuple((one["at"], one["device"], one["capability"], one["value"]) for one in own)
    control = draw(_CONTROL)
    if doors.guarded:
        control["presence_guard"]["doors"] = doors.guarded
    return RandomDay(day, control, apps, person, draw(st.integers(0, 100)), doors.rooms)


@st.composite
def _things(draw: DrawFn, rooms: Table, others: Table) -> Table:
    """Draw the lamps and motion sensors of *rooms*, beside *others*, whose contacts get faults of sensors."""
    things = dict(others)
    hold = draw(st.sampled_from(({}, {"hold": 5.0})))
    for room in rooms:
        if draw(st.integers(0, 4)):  # most rooms have both
            things[f"{room}_lamp"] = {"kind": "lamp", "room": room, "faults": draw(_some(_A_LAMP_FAULT))}
            things[f"{room}_motion"] = {"kind": "motion", "room": room, "faults": draw(_some(_SENSOR_FAULTS)), **hold}
    for thing in things.values():
        if thing["kind"] == "contact":
            thing["faults"] = draw(_some(_SENSOR_FAULTS))
    return things


def _walk(start: float, motions: Iterable[str], contacts: Iterable[str]) -> list[DayEvent]:
    """Return how somebody walks past each of *motions*, and leaves through all doors, which have *contacts*."""
    return [
        *(DayEvent(start + _WALK, "press", name, "motion") for name in motions),
        *(DayEvent(start + _LEFT, "press", name, "open") for name in contacts),
        *(DayEvent(start + _LEFT + 1.0, "press", name, "close") for name in contacts),
    ]


@st.composite
def _some(draw: DrawFn, faults: SearchStrategy[Table]) -> Table:
    """Draw tables of faults; most are empty."""
    return {} if draw(st.integers(0, 3)) else draw(faults)


def _orders(things: tuple[tuple[str, str], ...], length: float) -> SearchStrategy[list[Table]]:
    if not things:
        return st.just([])
    return st.lists(_order(things, length), max_size=12)


@st.composite
def _order(draw: DrawFn, things: tuple[tuple[str, str], ...], length: float) -> Table:
    device, kind = draw(st.sampled_from(things))
    capability, value, text = draw(st.sampled_from(_ORDERS[kind]))
    at = draw(st.integers(0, int(length))) if draw(st.booleans()) else 600 + draw(st.integers(0, 20))
    return {
        "at": float(at),
        "device": device,
        "capability": capability,
        "value": value,
        "text": text if draw(st.booleans()) else "",
    }


_CONTROL: SearchStrategy[Table] = st.fixed_dictionaries(
    {
        "time_zone": st.just("UTC"),
        "presence_guard": st.fixed_dictionaries({"absent_after": st.sampled_from((300.0, 10.0))}),
        "rate_limit": st.fixed_dictionaries({"changes": st.integers(1, 4), "seconds": st.just(10.0)}),
        "quiet_hours": st.sampled_from(
            ([], [{"start": "22:00", "end": "07:00", "commands": ["turn on lights", "use thermostats"]}])
        ),
        "interlocks": st.just([{"commands": ["heat thermostats"], "while": "open contact sensor", "where": "room"}]),
    }
)
