"""The text that narrows a search down loses nothing that is wanted."""

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from homebot.devices import Device, DevicePart, Endpoint, State
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.handles import Closure, ContactSensor, Handle, Light, TemperatureSensor, Thermostat, WindowCovering
from homebot.devices.part import Capability, Part
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.term_messages import query_terms, read_terms
from homebot.devices.value import PlainValue, Value
from homebot.messages import Time

NOW = Time(sec=0, nanosec=0)
TYPES = ("light", "closure", "contact_sensor", "window_covering", "temperature_sensor", "thermostat", "plug")
WORDS = ("lights", "lamp", "windows", "Window", "door", "garage door", "covers", "temperature", "heating", "robots", "")

_areas = st.sampled_from(["", "kitchen", "Küche", "kitchen floor", 'a "b" and (c', "-", "or"])
_values: st.SearchStrategy[PlainValue] = st.sampled_from(
    [None, True, False, 0.0, -3.5, 21.25, 1e-9, 1e30, "open", "closed", "Heat up", "heat", '"']
)
_capabilities = st.sampled_from(["on_off", "level", "movement", "contact", "temperature", "thermostat_mode"])


@st.composite
def _devices(draw: st.DrawFn) -> Device:
    parts, states = [], []
    for number in range(draw(st.integers(0, 2))):
        names = draw(st.lists(_capabilities, unique=True, max_size=3))
        capabilities = tuple(Capability(name=one, settable=draw(st.booleans())) for one in names)
        service_type = draw(st.sampled_from(TYPES))
        category: Any = draw(st.sampled_from(["", "config"]))
        part = Part(id=str(number), service_type=service_type, category=category, capabilities=capabilities)
        parts.append(DevicePart(id=str(number), part=part, routes=()))
        states += [
            State(part=str(number), capability=one, value=Value.of(draw(_values)), since=NOW, told_at=NOW, live=True)
            for one in names
        ]
    command_address = draw(st.sampled_from(["", "in"]))
    return Device(
        id="x",
        name="X",
        service_type=draw(st.sampled_from((*(one.part.service_type for one in parts), *WORDS))),
        endpoints=(Endpoint(gateway="mqtt", key="x", address="out", command_address=command_address),),
        metadata=(),
        first_seen=NOW,
        last_seen=NOW,
        expires=NOW,
        freshness="fresh",
        area=draw(_areas),
        parts=tuple(parts),
        states=tuple(states),
    )


_numbers = st.none() | st.sampled_from([-4.0, 0.0, 1e-9, 21.25, 1e29])
_flags = st.none() | st.booleans()


@given(
    device=_devices(),
    area=_areas,
    flag=_flags,
    can=_flags,
    number=_numbers,
    mode=st.sampled_from([None, "heat", "HEAT_UP", '"']),
    category=st.sampled_from(["", "config", "diagnostic"]),
)
def test_every_matching_handle_is_found_by_the_query_for_devices(
    *,
    device: Device,
    area: str,
    flag: bool | None,
    can: bool | None,
    number: float | None,
    mode: str | None,
    category: str,
) -> None:
    """For every kind of question."""
    place: Any = ({"area": area} if area else {}) | ({"category": category} if category else {})
    for wanted in (
        Handle.where(**place),
        Light.where(on=flag, dimmable=can, **place),
        Closure.where(closed=flag, **place),
        WindowCovering.where(closed=flag, **place),
        ContactSensor.where(is_open=flag, **place),
        TemperatureSensor.where(above=number, **place),
        Thermostat.where(mode=mode, **place),
    ):
        if list(wanted.parts(device)):
            query = read_terms(query_terms(wanted.search))
            assert fits(query, facets_of(device)), query


def test_every_kind_has_a_query_that_travels() -> None:
    """For each type of the vocabulary that some class of handles is about."""
    kinds: list[type[Handle]] = [Handle, *_all_kinds(Handle)]
    for kind in kinds:
        assert kind.service_types <= DEVICE_TYPES.keys()
        query = kind.where().search
        assert read_terms(query_terms(query)) == query


def _all_kinds(kind: type[Handle]) -> list[type[Handle]]:
    found: list[type[Handle]] = []
    for direct in kind.__subclasses__():
        found += [direct, *_all_kinds(direct)]
    return found
