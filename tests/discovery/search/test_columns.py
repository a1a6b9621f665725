"""Columns, against a table of the same values."""

from hypothesis import given
from hypothesis import strategies as st

from homebot.devices.query.terms import StateIs
from homebot.devices.value import PlainValue, Value
from homebot.discovery.search.columns import Column, StoredValue
from homebot.messages import Time
from homebot.words.queries import parse_query

NOW = Time(sec=0, nanosec=0)
VALUES = st.sampled_from([True, False, 1.0, 50.0, 98.0, "open"])
STEPS = st.lists(st.tuples(st.sampled_from(["add", "change", "discard"]), st.integers(0, 5), VALUES), max_size=60)


def stored(value: PlainValue) -> StoredValue:
    return StoredValue(Value.of(value), value, NOW, NOW, live=True)


def state(text: str) -> StateIs:
    query = parse_query(text)
    assert isinstance(query, StateIs)
    return query


@given(STEPS)
def test_a_column_finds_what_its_values_are_now(steps: list[tuple[str, int, PlainValue]]) -> None:
    column = Column()
    values: dict[str, StoredValue] = {}
    for step, number, value in steps:
        device = f"device {number}"
        if step == "add" and device not in values:
            values[device] = stored(value)
            column.add(device, values[device])
        elif step == "change" and device in values:
            one = values[device]
            one.value = value
            assert one.column is not None
            one.column.values[one.row] = value
        elif step == "discard" and device in values:
            column.discard(device, values.pop(device))
    now = {device: one.value for device, one in values.items()}
    assert column.fitting(state("on")) == {device for device, value in now.items() if value is True}
    assert column.fitting(state("level > 40")) == {device for device, value in now.items() if value in {50.0, 98.0}}
    ones = {device for device, value in now.items() if value == 1.0 and value is not True}
    assert column.fitting(state("level = 1")) == ones


def test_a_value_that_went_to_another_device_or_column_is_found_there_alone() -> None:
    column, other, value = Column(), Column(), stored(value=True)
    column.add("a", value)
    column.add("b", value)
    column.discard("a", value)
    assert column.fitting(state("on")) == {"b"}
    other.add("b", value)
    column.discard("b", value)
    assert (column.fitting(state("on")), other.fitting(state("on"))) == (set(), {"b"})
