"""The form that nine of ten templates have."""

import pytest

from homebot.conventions.jinja import NotDefinedError, PayloadContext, TemplateError, compile_template


@pytest.mark.parametrize(
    ("source", "payload", "text"),
    [
        ("{{ value }}", " on ", "on"),
        ("{{value}}", '{"a": 1}', '{"a": 1}'),
        ("{{ value_json.a }}", '{"a": 1}', "1"),
        ("  {{- value_json.a.b -}}  ", '{"a": {"b": "x "}}', "x"),
        ('{{ value_json["k"] }}', '{"k": true}', "True"),
        ("{{ value_json['a']['b c'] }}", '{"a": {"b c": null}}', "None"),
        ("{{ value_json['a'].b[0] }}", '{"a": {"b": [2.50]}}', "2.5"),
        ('{{ value_json[""] }}', '{"": 5}', "5"),
        ("{{ value_json.items }}", '{"items": 5}', "5"),
        ("{{ value_json['_type'] }}", '{"_type": "location"}', "location"),
        ("{{ value_json }}", "21.5", "21.5"),
        ("{{ value_json }}", "no json", ""),
        ("{{ value_json.missing }}", '{"a": 1}', ""),
        ("{{ value_json.a.missing }}", '{"a": 1}', ""),
        ("{{ value_json[9] }}", "[1]", ""),
        ("{{ value_json[1] }}", '"text"', "e"),
        ("{{ value_json.a }}", '{"a": {"b": [1, "x"]}}', "{'b': [1, 'x']}"),
        ("{{ value_json.a | is_defined }}", '{"a": false}', "False"),
    ],
)
def test_a_path_gives_the_text_of_what_is_there(source: str, payload: str, text: str) -> None:
    template = compile_template(source)

    assert template.problem == ""
    assert template.render_value(payload) == text


@pytest.mark.parametrize("source", ["{{ value_json.a.b }}", "{{ value_json.a['b'].c }}"])
def test_a_path_through_what_is_not_there_fails(source: str) -> None:
    with pytest.raises(TemplateError, match="not in the message"):
        compile_template(source).render_value('{"x": 1}')


def test_what_is_not_defined_is_told_apart_from_a_failure() -> None:
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
