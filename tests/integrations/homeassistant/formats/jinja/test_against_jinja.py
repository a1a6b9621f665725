"""Random templates of Jinja's own features give the text of Jinja's sandbox."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jinja2.sandbox import ImmutableSandboxedEnvironment
from tests.sizes import examples

from homebot.integrations.homeassistant.formats.jinja import TemplateError, compile_template

pytestmark = pytest.mark.slow

ENVIRONMENT = ImmutableSandboxedEnvironment(extensions=["jinja2.ext.loopcontrols"])

KEYS = st.sampled_from(["a", "b", "c", "ab"])
SCALARS = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-300, 300),
    st.floats(-1e6, 1e6).map(lambda number: round(number, 3)),
    st.sampled_from(["", "a", "ON", "off", "Hello world", "12.5", " x ", "a,b", "1", "ü"]),
)
JSON = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS, inner, max_size=3), max_leaves=8
)

LEAVES = st.one_of(
    st.just("value_json"),
    st.just("value"),
    st.just("nothing"),
    KEYS.map(lambda key: f"value_json.{key}"),
    KEYS.map(lambda key: f"value_json['{key}']"),
    st.sampled_from(
        ["0", "1", "2.5", "-3", "'a'", "'ON'", "'12'", "''", "none", "true", "false", "[1, 2]", "{'a': 1}"]
    ),
)
READ = st.one_of(st.just("value_json"), st.just("value"), KEYS.map("value_json.{}".format))
FILTERS = st.sampled_from(
    [
        "default('d')",
        "default('d', true)",
        "lower",
        "upper",
        "title",
        "capitalize",
        "trim",
        "string",
        "length",
        "first",
        "last",
        "list",
        "join(',')",
        "sort",
        "unique | list",
        "reverse | list",
        "abs",
        "sum",
        "min",
        "max",
        "replace('a', 'bb')",
        "truncate(5, true, '', 0)",
        "truncate(6)",
        "tojson",
        "items | list",
        "dictsort",
        "map(attribute='a') | list",
        "select | list",
        "selectattr('a') | list",
        "map('upper') | list",
        "format(1)",
    ]
)
TESTS = st.one_of(
    st.sampled_from(["defined", "undefined", "none", "number", "string", "mapping", "iterable", "sequence", "boolean"]),
    st.sampled_from(["eq 1", "ne 'a'", "in [1, 'a', none]", "sameas none", "lower", "integer", "divisibleby 2", "odd"]),
)
METHODS = st.sampled_from(["get('a')", "get('c', 5)", "split(',')", "upper()", "startswith('a')", "replace('a', '')"])
OPERATORS = st.sampled_from(
    ["+", "-", "*", "/", "//", "%", "~", "==", "!=", "<", "<=", ">", ">=", "and", "or", "in", "not in"]
)


def grown(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.one_of(
        st.builds("({} {} {})".format, inner, OPERATORS, inner),
        st.builds("({} | {})".format, inner, FILTERS),
        st.builds("({} is {})".format, inner, TESTS),
        st.builds("({}.{})".format, inner, METHODS),
        st.builds("({} if {} else {})".format, inner, inner, inner),
        st.builds("({}[{}])".format, inner, inner),
        st.builds("({}[{}:{}])".format, READ, st.sampled_from(["", "1", "-2"]), st.sampled_from(["", "2", "-1"])),
        st.builds("({}.{})".format, inner, KEYS),
        st.builds("[{}, {}]".format, inner, inner),
        st.builds("(not {})".format, inner),
        st.builds("(-{})".format, inner),
    )


EXPRESSIONS = st.recursive(LEAVES, grown, max_leaves=6)


def block(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.one_of(
        st.builds("{}{}".format, inner, inner),
        st.builds("{{% if {} %}}{}{{% else %}}{}{{% endif %}}".format, EXPRESSIONS, inner, inner),
        st.builds("{{%- if {} -%}} {} {{%- elif {} %}}{}{{% endif %}}".format, EXPRESSIONS, inner, EXPRESSIONS, inner),
        st.builds("{{% set a = {} %}}{}{{{{ a }}}}".format, EXPRESSIONS, inner),
        st.builds("{{% for a in {} %}}{{{{ loop.index }}}}{}{{% else %}}-{{% endfor %}}".format, EXPRESSIONS, inner),
        st.builds("{{% set a %}}{}{{% endset %}}{{{{ a | length }}}}".format, inner),
    )


TEMPLATES = st.recursive(EXPRESSIONS.map("{{{{ {} }}}}".format) | st.just("text "), block, max_leaves=4)


@settings(max_examples=examples(300), deadline=None, derandomize=True)
@given(template=TEMPLATES, content=JSON)
def test_a_template_is_rendered_or_refused_as_by_jinja(template: str, content: object) -> None:
    payload = json.dumps(content)
    expected: str | None
    try:
        expected = ENVIRONMENT.from_string(template).render(value=payload, value_json=content).strip()
    except Exception:  # noqa: BLE001  # of any kind
        expected = None

    compiled = compile_template(template)
    rendered: str | None
    try:
        rendered = compiled.render_value(payload)
    except TemplateError:
        rendered = None

    assert compiled.problem == ""
    assert rendered == expected
