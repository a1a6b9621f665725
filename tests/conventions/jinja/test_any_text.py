"""Any source and any values give a text or a TemplateError."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.sizes import examples

from homebot.conventions.jinja import TemplateError, compile_template
from homebot.conventions.jinja.functions import FILTERS, FUNCTIONS
from homebot.conventions.jinja.lists import CHECKS
from homebot.conventions.jinja.texts import METHODS

pytestmark = pytest.mark.slow

JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(max_size=20)
    | st.sampled_from(["%d", "{0}", "[", "a*", "2024-01-01", "utf-8", ">I", "b", "%s%s"]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner, max_size=4),
    max_leaves=10,
)
ARGUMENTS = st.sampled_from(["", "a", "b", "a, b", "b, c", "b, c, a", "x=b"])
FILTER = st.sampled_from(sorted(FILTERS))
CHECK = st.sampled_from(sorted(filter(str.isidentifier, CHECKS)))
OPERATOR = st.sampled_from(["+", "-", "*", "/", "//", "%", "**", "~", "<", "==", "in", "not in"])
NAMES = [name for methods in METHODS.values() for name in methods]
CALLS = st.one_of(
    st.builds("{{{{ a | {}({}) }}}}".format, FILTER, ARGUMENTS),
    st.builds("{{{{ a is {}({}) }}}}".format, CHECK, ARGUMENTS),
    st.builds("{{{{ {}({}) }}}}".format, st.sampled_from(sorted(FUNCTIONS)), ARGUMENTS),
    st.builds("{{{{ a.{}({}) }}}}".format, st.sampled_from(NAMES), ARGUMENTS),
    st.builds("{{{{ a {} b }}}}".format, OPERATOR),
    st.builds("{{{{ a | {} | {} }}}}".format, FILTER, FILTER),
    st.builds("{{{{ a | map('{}', b) | list }}}}".format, FILTER),
    st.builds("{{{{ a | select('{}', b) | list }}}}".format, CHECK),
    st.sampled_from(["{{ a[b] }}", "{{ a[b:c] }}", "{{ {a: b} }}", "{{ -a }}", "{{ +a }}"]),
    st.just("{% for x, y in a %}{{ x }}{% endfor %}"),
)


@settings(max_examples=examples(400), deadline=None)
@given(source=CALLS, a=JSON, b=JSON, c=JSON)
def test_any_function_takes_any_values(source: str, a: object, b: object, c: object) -> None:
    template = compile_template(source)
    assert template.problem == ""

    with contextlib.suppress(TemplateError):
        text = template.render({"a": a, "b": b, "c": c})
        assert len(text.encode()) >= len(text)
