"""JSON of many megabytes: the same values as in one go, in slices that are short."""

import json
from itertools import pairwise
from random import Random

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from homebot.conventions.long_json import is_longer_than, parse_in_slices
from homebot.conventions.payload import DuplicateKeys, parse_json
from homebot.errors import WireError

pytestmark = pytest.mark.slow

LIMIT = 32 * 1024 * 1024
JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**20), 10**20)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=12) | st.dictionaries(st.text(max_size=80), inner, max_size=12),
    max_leaves=40,
)


def parsed(text: bytes) -> tuple[object, list[int]]:
    """Return the value, and where there was a pause."""
    slices = parse_in_slices(text, LIMIT)
    pauses: list[int] = []
    while True:
        try:
            pauses.append(next(slices))
        except StopIteration as done:
            return done.value, pauses


@given(JSON, st.sampled_from([None, 1]), st.booleans())
def test_a_text_in_slices_has_the_value_that_it_has_in_one_go(value: object, indent: int | None, escaped: bool) -> None:  # noqa: FBT001
    text = json.dumps(value, indent=indent, ensure_ascii=escaped).encode(errors="replace")
    try:
        whole = parse_json(text, LIMIT)
    except WireError:
        with pytest.raises(WireError):
            parsed(text)
    else:
        assert repr(parsed(text)[0]) == repr(whole)


@given(
    JSON, st.integers(0, 2**32), st.sampled_from([b",", b"]", b"}", b'"', b"[", b"{", b" ", b"\\", b"\xff", b"0", b""])
)
@example([1, 2], 0, b"")
def test_a_broken_text_is_refused_in_slices_as_in_one_go(value: object, seed: int, sign: bytes) -> None:
    text = json.dumps(value).encode()
    at = Random(seed).randrange(len(text) + 1)  # noqa: S311 - a test case
    broken = text[:at] + sign + text[at + 1 :]
    try:
        whole = parse_json(broken, LIMIT)
    except WireError:
        with pytest.raises(WireError):
            parsed(broken)
    else:
        assert repr(parsed(broken)[0]) == repr(whole)


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"[",
        b"[1,]",
        b"[,1]",
        b'{"a":1,}',
        b'{"a" 1}',
        b"{1:2}",
        b"[1] [2]",
        b"[1" + b",1" * 100,
        b"[1" + b",1" * 100 + b",,1]",
        b"[NaN" + b",1" * 100 + b"]",
        b"[1e999" + b",1" * 100 + b"]",
        b'["\\ud800"' + b",1" * 100 + b"]",
        b'["' + b"x" * 200 + b"]",
        b"[" * 65 + b"1" + b"]" * 65,
        b"[" * 20 + b"1" * 40 + b",[" * 50 + b"]" * 70,
        b"[" * 100_000,
        b'{"a":' * 100_000,
        b'["\xc3',
        b'["' + b"x" * 55 + b'",1e-]',
    ],
)
def test_invalid_json_is_refused(text: bytes) -> None:
    with pytest.raises(WireError):
        parsed(text)


def test_a_text_that_is_too_long_is_refused_before_it_is_parsed() -> None:
    with pytest.raises(WireError, match="longer than 3"):
        next(parse_in_slices(b"[1]]", 3))


def test_sixty_four_levels_are_parsed() -> None:
    text = b"[" * 64 + b"]" * 64
    assert parsed(text)[0] == json.loads(text)


@pytest.mark.parametrize("text", [b"[%s]", b'{"result": [%s], "id": 1}', b' [ [ ] , { "members" : [ %s ] } ]'])
def test_there_is_a_pause_behind_each_member(text: bytes) -> None:
    member = b'{"a": [1, {"b": 2}], "c": "]},"}'
    text %= b", ".join([member] * 100)
    value, pauses = parsed(text)
    assert value == json.loads(text)
    if b"members" not in text:
        assert max(second - first for first, second in pairwise([0, *pauses])) < 3 * len(member)


def test_keys_that_are_there_twice_are_noted_across_slices() -> None:
    text = b'{"same": 1,' + b",".join(b'"key %d": 1' % number for number in range(100)) + b', "same": 2}'
    with DuplicateKeys() as repeated:
        value, _ = parsed(text)
    assert repeated == ["same"]
    assert isinstance(value, dict)
    assert value["same"] == 2


@given(JSON)
def test_the_length_of_a_value_is_at_most_that_of_its_text(value: object) -> None:
    text = json.dumps(value, separators=(",", ":"), ensure_ascii=False)
    assert not is_longer_than(value, len(text))


@pytest.mark.parametrize(
    "value", [["a" * 50] * 20, {"a" * 50: {str(n): [n] for n in range(200)}}, [[]] * 1000, "x" * 1001]
)
def test_a_long_value_is_longer(value: object) -> None:
    assert is_longer_than(value, 500)
