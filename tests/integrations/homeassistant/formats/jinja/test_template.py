"""Compiled templates, paths, and the problems of unsupported templates."""

import json
from datetime import UTC, datetime
from itertools import product
from zoneinfo import ZoneInfo

import pytest

from homebot.clock import home_time
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.jinja import (
    NotDefinedError,
    PayloadContext,
    TemplateError,
    compile_template,
)
from homebot.integrations.homeassistant.formats.jinja.values import UndefinedValueError


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("{{ states('sensor.x') }}", "uses `states()`, which only Home Assistant has"),
        ("{{ states.sensor.x.state }}", "uses `states`, which only Home Assistant has"),
        ("{{ trigger.id }}", "uses `trigger`, which only Home Assistant has"),
        ("{{ is_state('a.b', value) }}", "uses `is_state()`, which only Home Assistant has"),
        ("{{ value | shuffle }}", "uses the filter `shuffle`, which is not supported"),
        ("{{ value is callable }}", "uses the test `callable`, which is not supported"),
        ("{{ foo() }}", "uses the function `foo()`, which is not supported"),
        ("{{ value_json.l.append(4) }}", "uses the method `append()`, which is not supported"),
        ("{{ ''.__class__.__mro__() }}", "uses the method `__mro__()`, which is not supported"),
        ("{{ value_json['a']() }}", "calls something that is not a function"),
        ("{{ max(*value_json) }}", "calls with `*` or `**`, which is not supported"),
        ("{% macro m() %}x{% endmacro %}", "uses `macro`, which is not supported"),
        ("{% include 'x' %}", "uses `include`, which is not supported"),
        ("{% import 'x' as y %}", "uses `import`, which is not supported"),
        ("{% extends 'x' %}", "uses `extends`, which is not supported"),
        ("{% for a in value recursive %}{% endfor %}", "uses a recursive loop, which is not supported"),
        ("{% break %}", "uses `break` outside a loop"),
        ("{% for a in value %}{% set b %}{% continue %}{% endset %}{% endfor %}", "uses `continue` outside a loop"),
        ("{{ value_json. }}", "is not a valid template: expected name or number"),
        ("{{ 'unclosed }}", 'is not a valid template: unexpected char "\'" at 3'),
        ("{% unknown %}", "is not a valid template: Encountered unknown tag 'unknown'."),
        ("x" * 8193, "is longer than 8192 characters"),
        ("{{ " + "a+" * 600 + "a }}", "has more than 1024 tokens"),
        ("{{ " + "(" * 70, "is nested too deeply"),
        ("{{ 1" + "+1" * 100 + " }}", "is nested too deeply"),
        ("{{ " + "9" * 5000 + " }}", "has a number or text that cannot be read"),
        ("{{ 0x" + "f" * 100 + " }}", "has a number that is too large"),
        ("{% for a in b %}" * 5 + "{% endfor %}" * 5, "has more than 4 nested loops"),
    ],
)
def test_an_unsupported_feature_is_named_in_a_sentence(source: str, problem: str) -> None:
    template = compile_template(source)

    assert template.problem == problem
    with pytest.raises(TemplateError) as caught:
        template.render_value("1")
    assert str(caught.value) == f"the template {problem}"
    assert isinstance(caught.value, WireError)


def test_equal_texts_share_one_template() -> None:
    assert compile_template("{{ value | int }}") is compile_template("{{ value | int }}")


def test_a_name_that_a_template_sets_itself_is_its_own() -> None:
    assert compile_template("{% set this = 4 %}{{ this }}").render({}) == "4"


def test_a_template_that_asks_for_its_own_last_value_changes_nothing() -> None:
    """``mapping.yaml`` of HA_enoceanmqtt: one message tells the power or the energy of a plug."""
    template = compile_template(
        "{% if value_json.UN == 3 %}{{ value_json.MV }}{% else %}{{ states(entity_id) }}{% endif %}"
    )
    assert template.render_value('{"UN": 3, "MV": 75}') == "75"
    with pytest.raises(UndefinedValueError):
        template.render_value('{"UN": 1, "MV": 1200}')


def test_the_variables_of_the_caller_stay_as_they_are() -> None:
    variables: dict[str, object] = {"a": [1], "d": {"x": 1}}

    text = compile_template("{% set a = a + [2] %}{% set d = dict(x=2) %}{{ a }}{{ d }}").render(variables)

    assert text == "[1, 2]{'x': 2}"
    assert variables == {"a": [1], "d": {"x": 1}}


def test_each_rendering_starts_anew() -> None:
    template = compile_template("{% set n = namespace(x=value | int) %}{% set n.x = n.x + 1 %}{{ n.x }}")

    assert [template.render_value("1"), template.render_value("5"), template.render_value("1")] == ["2", "6", "2"]


def test_an_error_at_run_time_names_the_value_that_does_not_fit() -> None:
    with pytest.raises(TemplateError, match="float is given a str that it cannot convert, and no default"):
        compile_template("{{ value | float }}").render_value("warm")
    with pytest.raises(TemplateError, match="division by zero"):
        compile_template("{{ 1 / (value | int) }}").render_value("0")


def test_half_a_surrogate_pair_is_no_text() -> None:
    with pytest.raises(TemplateError, match="surrogate"):
        compile_template(r"{{ '\ud800' }}").render({})
    with pytest.raises(TemplateError, match="surrogate"):
        compile_template("{{ value }}").render({"value": "\ud800"})


def test_an_error_shows_no_value() -> None:
    template = compile_template("{{ [1, 2].index(code | int) }}{{ code | from_json }}")

    with pytest.raises(TemplateError) as caught:
        template.render({"code": "4711"})

    assert "4711" not in str(caught.value)
    assert caught.value.__cause__ is None


@pytest.mark.parametrize("expression", [r"\d+$", "[[]?5", "[0-9--]"])
def test_warnings_of_python_are_ignored(expression: str) -> None:
    assert compile_template(f"{{{{ value | regex_search('{expression}') }}}}").render_value("5") == "True"


@pytest.mark.parametrize("source", ["{{ value_json.a.b }}", "{{ value_json.a['b'].c }}"])
def test_a_path_through_a_missing_value_fails(source: str) -> None:
    with pytest.raises(TemplateError, match="not in the message"):
        compile_template(source).render_value('{"x": 1}')


def test_an_undefined_value_is_no_failure() -> None:
    with pytest.raises(NotDefinedError):
        compile_template("{{ value_json.tempc | is_defined }}").render_value('{"hum": 1}')


def test_a_path_is_rendered_from_given_variables() -> None:
    template = compile_template("{{ value_json.a }}")

    assert template.render({"value": "", "value_json": {"a": "on"}}) == "on"
    assert compile_template("{{ value_json }}").render({}) == ""


def test_the_json_of_a_message_is_read_once() -> None:
    payload = PayloadContext('{"a": 1, "b": 2}')

    assert compile_template("{{ value_json.a }}").render_value(payload) == "1"
    assert payload.value_json is payload.value_json


def test_a_huge_value_is_refused() -> None:
    with pytest.raises(TemplateError, match="longer than"):
        compile_template("{{ value }}").render_value("x" * 70_000)
    with pytest.raises(TemplateError, match="more than"):
        compile_template("{{ value_json }}").render_value("[" + "1," * 30_000 + "1]")


STEPS = (
    "",
    ".a",
    ".if",
    "._b",
    "['a']",
    '["b c"]',
    "['']",
    "[ 'a' ]",
    ".items",
    "[0]",
    ".A1",
    "['a-b']",
    ".",
    "['a', 'b']",
)


def test_a_path_in_json_is_as_jinja_parses_it() -> None:
    """In parentheses it is no mere path, and left to Jinja's parser."""

    def rendered(template: str, content: object) -> str:
        compiled = compile_template(template)
        try:
            return compiled.problem or compiled.render_value(json.dumps(content))
        except TemplateError as error:
            return f"{type(error).__name__}: {error}"

    inner = {"a": "A", "if": 1, "_b": True, "b c": [], "": "none", "A1": None, "a-b": 2, "items": 3}
    contents = ({**inner, "a": inner, "b c": inner, "items": inner}, [inner], None, "text")
    for first, second, content in product(STEPS, STEPS, contents):
        path = f"value_json{first}{second}"
        assert rendered(f"{{{{ {path} }}}}", content) == rendered(f"{{{{ ({path}) }}}}", content), path


@pytest.mark.parametrize(
    "source",
    [
        "{{ now() }}",
        "{{ utcnow() }}",
        "{{ 0 | timestamp_custom('%Y') }}",
        "{{ as_datetime('2026-03-04T05:06:07') | as_local }}",
        "{{ as_timestamp('1970-01-01T02:00:00') }}",
    ],
)
def test_without_a_clock_local_time_fails(source: str) -> None:
    with pytest.raises(TemplateError, match="not available here"):
        compile_template(source).render_value("")


@pytest.mark.parametrize("name", ["timestamp_utc", "timestamp_local"])
def test_absolute_time_needs_no_clock(name: str) -> None:
    assert compile_template(f"{{{{ 0 | {name} }}}}").render({}) == datetime.fromtimestamp(0, UTC).isoformat()


@pytest.mark.parametrize(
    ("source", "text"),
    [
        ("{{ now().isoformat() }}", "2026-07-01T14:30:00+02:00"),
        ("{{ utcnow().isoformat() }}", "2026-07-01T12:30:00+00:00"),
        ("{{ now() | attr('hour') }}", "14"),
        ("{{ 1782900000 | timestamp_local }}", "2026-07-01T12:00:00+02:00"),
        ("{{ 1767225600 | timestamp_local }}", "2026-01-01T01:00:00+01:00"),
        ("{{ 'x' | timestamp_local('never') }}", "never"),
        ("{{ 1782900000 | timestamp_custom('%H:%M') }}", "12:00"),
        ("{{ (as_datetime('2026-07-01T10:00:00+00:00') | as_local).isoformat() }}", "2026-07-01T12:00:00+02:00"),
        ("{{ (as_datetime('2026-07-01T10:00:00') | as_local).isoformat() }}", "2026-07-01T10:00:00+02:00"),
        ("{{ as_timestamp('2026-07-01T12:00:00') | int }}", "1782900000"),
        ("{{ (now() - as_datetime('2026-07-01T12:00:00+00:00')).total_seconds() | int }}", "1800"),
        ("{{ relative_time(as_datetime('2026-07-01T12:00:00+00:00')) }}", "30 minutes"),
        ("{{ as_datetime('2026-06-30T12:00:00') | relative_time }}", "1 day"),
        ("{{ as_datetime('2026-07-01T14:29:59') | relative_time }}", "1 second"),
        ("{{ relative_time(now()) }}", "0 seconds"),
        ("{{ relative_time(as_datetime('2027-01-01T00:00:00+00:00')).year }}", "2027"),
        ("{{ relative_time('soon') }}", "soon"),
    ],
)
def test_time_is_that_of_the_home(source: str, text: str) -> None:
    """As in Home Assistant 2025.4, ``helpers/template.py``."""
    noon = datetime(2026, 7, 1, 12, 30, tzinfo=UTC)
    before = home_time.set(lambda: noon.astimezone(ZoneInfo("Europe/Berlin")))
    try:
        assert compile_template(source).render({}) == text
    finally:
        home_time.reset(before)


@pytest.mark.parametrize(
    ("source", "text"),
    [
        ("{{ 'Büro Lampe-1' | slugify }}", "buro_lampe_1"),
        ("{{ slugify('A  b', '-') }}", "a-b"),
        ("{{ '日本' | slugify }}{{ '' | slugify }}", "unknown"),
        ("{{ {'a': 1, 'b': 2} | combine({'b': 3}, {'c': 4}) }}", "{'a': 1, 'b': 3, 'c': 4}"),
        ("{{ {'a': {'x': 1}} | combine({'a': {'y': 2}}, recursive=true) }}", "{'a': {'x': 1, 'y': 2}}"),
        ("{{ combine({'a': {'x': 1}}, {'a': {'y': 2}}) }}", "{'a': {'y': 2}}"),
        ("{{ {'a': 1} | attr('a') }}.", "."),
    ],
)
def test_names_and_mappings_are_made_as_in_home_assistant(source: str, text: str) -> None:
    assert compile_template(source).render({}) == text


def test_what_cannot_be_combined_fails() -> None:
    with pytest.raises(TemplateError, match="combine is given a list"):
        compile_template("{{ {} | combine([1]) }}").render({})


@pytest.mark.parametrize("form", ["%1000000000d", "%-5d", "%Y" * 40, "%"])
def test_a_format_of_times_has_plain_fields_only(form: str) -> None:
    with pytest.raises(TemplateError, match="plain fields"):
        compile_template("{{ 0 | timestamp_custom(form, false) }}").render({"form": form})


@pytest.mark.parametrize(
    ("source", "text"),
    [
        ("{{ strptime(value, '%d.%m.%Y %H:%M').isoformat() }}", "2026-03-04T05:06:00"),
        ("{{ as_timestamp(strptime(value ~ '+0200', '%d.%m.%Y %H:%M%z')) | int }}", "1772593560"),
        ("{{ (strptime(value, '%d.%m.%Y %H:%M') - timedelta(minutes=6)).hour }}", "5"),
        ("{{ strptime(value, '%Y', none) }}", "None"),
        ("{{ strptime(value, '%d%d', 'no time') }}", "no time"),
        ("{{ strptime(5, '%d', 'no time') }}", "no time"),
    ],
)
def test_a_time_is_read_by_its_format(source: str, text: str) -> None:
    assert compile_template(source).render_value("04.03.2026 05:06") == text


@pytest.mark.parametrize("value", ["soon", "1" * 300])
def test_a_time_in_another_format_fails_without_default(value: str) -> None:
    with pytest.raises(TemplateError, match="strptime"):
        compile_template("{{ strptime(value, '%d') }}").render_value(value)


def test_a_chain_of_defaults_takes_work_in_proportion_to_its_length() -> None:
    template = compile_template("{{ value_json.a" + "|default(value_json.b)" * 12 + "|default('x') }}")
    assert template.render_value(PayloadContext("{}")) == "x"


def test_a_number_that_is_none_in_a_payload_is_none_and_the_rest_is_read() -> None:
    template = compile_template("{{ value_json.h }},{{ value_json.t is none }}")
    assert template.render_value('{"t": nan, "h": 44}') == "44,True"
