import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.conventions.payload import (
    DuplicateKeys,
    as_fields,
    clean_text,
    compact_json,
    fields_of,
    meaning_reader,
    parse_json,
    parse_object,
    percent_of,
    read_number,
    shown,
    text_of,
    to_json,
    to_text,
)
from homebot.errors import WireError

json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4),
    max_leaves=12,
)


def test_keys_that_are_there_twice_are_noted_or_refused() -> None:
    """The last one counts where that is not asked for."""
    text = '{"a": 1, "b": {"c": 1, "c": 2}, "a": 3}'
    assert parse_json(text) == {"a": 3, "b": {"c": 2}}
    with DuplicateKeys() as keys:
        assert parse_json(text) == {"a": 3, "b": {"c": 2}}
        parse_json('{"a": [{"a": 1}, {"a": 2}]}')
    assert keys == ["c", "a"]
    with pytest.raises(WireError, match="the key 'c' occurs twice"):
        parse_json(text, unique=True)
    with DuplicateKeys() as keys:
        parse_json("[" + ",".join(['{"x": 1, "x": 2}'] * 1000) + "]")
    assert len(keys) == 10


@pytest.mark.parametrize(
    "text",
    [
        '{"a": 1, "a": 2, "b" : 3}',
        '{"a": 1, "a": 2, "b"\n: 3}',
        r'{"a": 1, "a": 2, "b\\": 3}',
        r'{"c": "\":", "a": 1, "a": 2}',
        r'{"a": 1, "\u0061": 2}',
        r'{"a": ":", "a": "\u003a\u003a\u003a"}',
        '{"a": "::", "a": ":"}',
        '{"c": {}, "d": [{"a": 1, "b": {"a": 2, "a": 3}}]}',
    ],
)
def test_a_key_that_is_there_twice_is_found_beside_any_other(text: str) -> None:
    with DuplicateKeys() as keys:
        parse_json(text.encode())
    assert keys == ["a"]


@given(json_values)
def test_json_is_parsed(value: object) -> None:
    assert parse_json(json.dumps(value).encode()) == value


def _parsed(payload: bytes | str) -> str:
    try:
        return repr(parse_json(payload))
    except WireError as error:
        return f"refused: {error.problem[-20:]}"


def _parsed_strictly(payload: bytes | str) -> str:
    with DuplicateKeys():
        return _parsed(payload)


json_texts = st.text(alphabet='{}[]",:\\ud8 0123456789.eE+-truefalsn\t\x00NaInity', max_size=20)
odd_numbers = st.from_regex(r"-?(0|[1-9][0-9]{0,30})(\.[0-9]{1,30})?([eE][+-]?[0-9]{1,4})?", fullmatch=True)


@given(json_texts | odd_numbers | odd_numbers.map(lambda number: f'{{"a": [{number}]}}') | json_values.map(json.dumps))
def test_both_parsers_read_the_same(text: str) -> None:
    for payload in (text, text.encode()):
        assert _parsed(payload) == _parsed_strictly(payload)


@pytest.mark.parametrize("depth", [1, 63, 64, 65, 66, 150, 300])
def test_the_fast_parser_takes_the_same_depth(depth: int) -> None:
    for text in ("[" * depth + "]" * depth, '{"a":' * depth + "1" + "}" * depth):
        assert _parsed(text) == _parsed_strictly(text)


@pytest.mark.parametrize(
    ("payload", "problem"),
    [
        (b"", "not JSON"),
        (b"\xff", "not JSON"),
        (b'\xef\xbb\xbf{"a": 1}', "not JSON"),
        (b"NaN", "NaN is not a number"),
        (b"[-Infinity]", "-Infinity is not a number"),
        (b"1e999", "too large"),
        (b"1" * 5000, "not JSON"),
        (b"[" * 10_000 + b"]" * 10_000, "deeper than 64"),
        (b"[" * 65 + b"]" * 65, "deeper than 64"),
        (b'{"a":' * 10_000, "no JSON|deeper than 64"),
        (b'"\\ud800"', "surrogate"),
        ('"\ud800"', "surrogate"),
        (b'{"\\uDC00": 1}', "surrogate"),
        (b" " * 300_000, "longer than"),
    ],
)
def test_invalid_json_is_refused(payload: bytes | str, problem: str) -> None:
    with pytest.raises(WireError, match=problem) as refused:
        parse_json(payload)
    assert len(str(refused.value)) < 300


def test_sixty_four_levels_and_a_whole_surrogate_pair_are_sane() -> None:
    assert parse_json(b"[" * 64 + b"1" + b"]" * 64)
    assert parse_json(b'"\\ud83d\\ude00"') == "\U0001f600"
    assert parse_json("[" + "[]," * 100 + "[]]") == [[]] * 101


@given(st.binary(max_size=200))
def test_any_bytes_are_json_or_a_wire_error(payload: bytes) -> None:
    try:
        parse_json(payload)
    except WireError:
        return
    json.loads(payload)


@pytest.mark.parametrize("payload", [b"[]", b"3", b"null", b'"text"'])
def test_an_object_is_asked_for_and_nothing_else_taken(payload: bytes) -> None:
    with pytest.raises(WireError, match="not a JSON object"):
        parse_object(payload)


@pytest.mark.parametrize(
    ("text", "clean"),
    [
        ("Kitchen lamp", "Kitchen lamp"),
        ("  blank  ", "blank"),
        ("a\x00b\x1b[31mc\n\td", "a b [31mc d"),
        ("left\u202eright", "left right"),
        ("<script>alert(1)</script>", "<script>alert(1)</script>"),
        ("Küche 灯 \U0001f4a1", "Küche 灯 \U0001f4a1"),
        ("\ud800x", "x"),
        ("n" * 100_000, "n" * 120),
        ("\x00" * 100_000, ""),
    ],
)
def test_a_name_is_one_short_visible_line(text: str, clean: str) -> None:
    assert clean_text(text) == clean


@pytest.mark.parametrize(
    ("value", "text"), [(" Hall\n", "Hall"), ("Hallway", "Hall"), (7, ""), (None, ""), (["Hall"], "")]
)
def test_a_value_that_is_no_text_is_an_empty_text(value: object, text: str) -> None:
    assert text_of(value, 4) == text


@given(st.text(max_size=400), st.integers(1, 60))
def test_a_clean_text_is_short_and_cleaning_it_again_changes_nothing(text: str, limit: int) -> None:
    clean = clean_text(text, limit)
    assert len(clean) <= limit
    assert clean_text(clean, limit) == clean


@given(json_values | st.binary(max_size=300))
def test_an_error_shows_any_value_on_one_short_line(value: object) -> None:
    assert len(shown(value)) <= 61
    assert "\n" not in shown(value)


def test_invalid_text_and_json_are_none() -> None:
    assert to_text(b"\xff") is None
    assert to_text(b"x" * 300_000) is None
    assert to_json(b"NaN") is None
    assert to_json(b'{"a":1}') == {"a": 1}


def test_a_table_of_meanings_reads_only_its_entries() -> None:
    read = meaning_reader("on_off", {"ON": True, "OFF": False, "unknown": None})
    assert [read(text) for text in ("ON", "OFF", "unknown", "on")] == [
        {"on_off": True},
        {"on_off": False},
        {"on_off": None},
        {},
    ]


@pytest.mark.parametrize(
    ("value", "percent"), [(0, 0.0), ("55.5", 55.5), (100, 100.0), (-1, None), (101, None), ("x", None)]
)
def test_a_percentage_outside_of_the_whole_is_unknown(value: object, percent: float | None) -> None:
    assert percent_of(value) == percent


def test_a_value_that_is_no_object_has_no_fields() -> None:
    assert as_fields({"a": 1}) == {"a": 1}
    assert [dict(as_fields(value)) for value in (None, [1], "a", 1)] == [{}, {}, {}, {}]


def test_json_is_written_without_spaces_and_in_unicode() -> None:
    assert compact_json({"a": [1, 2], "b": "ü"}) == '{"a":[1,2],"b":"ü"}'


def test_a_word_of_the_device_for_unknown_counts_beside_the_usual_ones() -> None:
    assert read_number("level", "n/a here", unknown="n/a here") == {"level": None}
    assert read_number("level", "n/a here") == {}


@pytest.mark.parametrize("word", ["nan", "NaN", "-nan", "-NaN", "NAN", "inf", "-inf", "Infinity", "-Infinity", "+inf"])
def test_a_number_that_is_none_is_null_and_the_rest_of_a_state_is_read(word: str) -> None:
    payload = f'{{"t": {word},"say":"{word}, \\"nan","h":44, "all": [{word}, 1,{word}]}}'
    expected = {"t": None, "say": f'{word}, "nan', "h": 44, "all": [None, 1, None]}
    assert parse_json(payload.encode(), lenient=True) == parse_json(payload, lenient=True) == expected
    assert fields_of(payload) == to_json(payload.encode()) == expected


@pytest.mark.parametrize(
    "payload",
    [b'{"t":nancy}', b'{"t":nan', b"nan", b'{"nan"}', b'{"t":"nan}', b'{"a":1e999}', b"\xff[nan]", b'["\xff",nan]'],
)
def test_a_state_that_is_no_json_without_these_numbers_is_refused(payload: bytes) -> None:
    with pytest.raises(WireError):
        parse_json(payload, lenient=True)
