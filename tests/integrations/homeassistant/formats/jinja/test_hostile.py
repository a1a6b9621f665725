"""Templates that would take for ever, or all memory, in Jinja's sandbox. The bound is on counted work, not on time."""

import json
from contextlib import suppress

import pytest

from homebot.conventions.description import begin_message, work_left
from homebot.integrations.homeassistant.formats.jinja import PayloadContext, TemplateError, compile_template
from homebot.integrations.homeassistant.formats.jinja.evaluation import Run
from homebot.integrations.homeassistant.formats.jinja.values import MAX_ITEMS, MAX_STEPS, MAX_TEXT

pytestmark = pytest.mark.slow

PAYLOAD = json.dumps({"l": list(range(MAX_ITEMS - 2)), "s": "b" * 100})

TOO_MUCH = "does too much work"
TOO_LONG = "more than 65536"
TOO_MANY = "more than 4096"


@pytest.mark.parametrize(
    ("source", "problem"),
    [
        ("{{ 'x' * 10**9 }}", TOO_LONG),
        ("{{ 10**9 * 'x' }}", TOO_LONG),
        ("{{ [0] * 10**9 }}", TOO_MANY),
        ("{{ (0,) * 10**9 }}", TOO_MANY),
        ("{{ range(99999999) | list }}", TOO_MANY),
        ("{{ 9**9**9 }}", "256 bits"),
        ("{{ (2**200) * (2**200) }}", "256 bits"),
        ("{{ 9.9**9999 }}", "do not fit"),
        ("{{ (-8) ** 0.5 }}", "not real"),
        ("{{ '%1000000d' % 1 }}", "large width"),
        ("{{ '%*d' % (10000000, 1) }}", "large width"),
        ("{{ '%.1000000f' % 1 }}", "large width"),
        ("{{ '%(a)1000000s' % {'a': 1} }}", "large width"),
        ("{{ '%1000000s' | format('x') }}", "large width"),
        ("{{ '%(a(b))1000000s' % {'a(b)': 1} }}", "large width"),
        ("{{ '%%' * 33 % () }}", "more than plain"),
        ("{{ '{:1000000d}'.format(1) }}", "large width"),
        ("{{ '{:٩٩٩٩٩٩٩}'.format(1) }}", "large width"),
        ("{{ ('{}' * 33).format(1) }}", "more than 32"),
        ("{{ '{:{}}'.format(1, 1000000) }}", "large width"),
        ("{{ '{0.__class__}'.format(value) }}", "plain values"),
        ("{{ '{0[a]}'.format({}) }}", "plain values"),
        ("{{ 1.5 | round(10**9) }}", "300 places"),
        ("{{ 1.5 | round(-10**9) }}", "300 places"),
        ("{{ ('[' * 60000) | from_json }}", "nested|JSON"),
        ("{{ ('9' * 60000) | from_json }}", "JSON"),
        ("{{ ('9' * 60000) | int }}", "that it cannot convert"),
        ("{{ ('9' * 60000) | float }}", "that it cannot convert"),
        ("{{ ('9' * 300) | int }}", "256 bits"),
        ("{{ ('a' * 60000) | replace('a', 'b' * 60000) }}", TOO_MUCH),
        ("{{ ('a' * 6000) | replace('a', 'b' * 600) }}", TOO_LONG),
        ("{{ ('a' * 60000).replace('', 'bbbb') }}", TOO_LONG),
        ("{{ (['x' * 60000] * 4000) | join }}", TOO_LONG),
        ("{{ ('y' * 60000).join(['a'] * 4000) }}", TOO_LONG),
        ("{{ (['a'] * 4000) | join('y' * 60000) }}", TOO_LONG),
        ("{{ 'x' | center(10**9) }}", TOO_LONG),
        ("{{ 'x'.ljust(10**9) }}", TOO_LONG),
        ("{{ 'x'.zfill(10**9) }}", TOO_LONG),
        ("{{ (' a' * 30000).split() }}", TOO_MANY),
        ("{{ (' a' * 30000) | title }}", TOO_MUCH),
        ("{{ value * 1000 }}", TOO_LONG),
        ("{% for a in value %}{{ a }}{% endfor %}", TOO_MANY),
        ("{% for a in range(4000) %}{% for b in range(4000) %}x{% endfor %}{% endfor %}", TOO_MUCH),
        ("{% for a in range(4000) %}{{ 'x' * 60000 }}{% endfor %}", TOO_MUCH + "|longer than"),
        ("{% set n = namespace(x='a') %}{% for i in range(99) %}{% set n.x = n.x + n.x %}{% endfor %}", TOO_LONG),
        ("{% set n = namespace(x=[1]) %}{% for i in range(99) %}{% set n.x = [n.x, n.x] %}{% endfor %}", TOO_MANY),
        ("{% set n = namespace(x={}) %}{% for i in range(99) %}{% set n.x = {1: n.x, 2: n.x} %}{% endfor %}", TOO_MANY),
        ("{% set n = namespace(x=(1,)) %}{% for i in range(999) %}{% set n.x = (n.x,) %}{% endfor %}", TOO_MUCH),
        ("{% set n = namespace(x=3) %}{% for i in range(99) %}{% set n.x = n.x * n.x %}{% endfor %}", "256 bits"),
        ("{{ ('a' * 60000) | regex_match('(a+)+b') }}", "nests repetitions"),
        ("{{ ('a' * 6000) | regex_match('(a+)?(a+)?b') }}", TOO_MUCH),
        ("{{ ('a' * 60) | regex_search('(a|aa)*b') }}", "nests repetitions"),
        ("{{ ('a' * 60) | regex_search('(?:(?:a*)*)*b') }}", "nests repetitions"),
        (r"{{ ('a' * 60) | regex_search('(a*)\\1b') }}", "refers"),
        ("{{ ('a' * 60) | regex_search('(?=a*)b') }}", "looks around"),
        ("{{ ('a' * 60000) | regex_search('a*b') }}", TOO_MUCH),
        ("{{ ('a' * 200) | regex_search('a*a*a*b') }}", TOO_MUCH),
        ("{{ ('a' * 60) | regex_search('a?' * 30) }}", TOO_MUCH),
        ("{{ ('a' * 60) | regex_search('(a|b)' * 30) }}", TOO_MUCH),
        ("{{ 'a' | regex_search('(' * 100) }}", "is wrong"),
        ("{{ 'a' | regex_search('a' * 201) }}", "200 characters"),
        (r"{{ ('a' * 900) | regex_replace('a', '\\g<0>' * 100) }}", TOO_LONG),
        ("{% for i in range(999) %}{{ 'a' | regex_search('a' ~ i) }}{% endfor %}", TOO_MUCH),
        ("{{ 'a' | regex_search('[Ā-ž][Ā-ž][Ā-ž]') }}", TOO_MUCH),
        (r"{{ 'a' | regex_search('[\\u0001-\\uffff]' * 3) }}", TOO_MUCH),
        ("{% for i in range(99) %}{{ strptime('1', '%d' ~ i, 0) }}{% endfor %}", TOO_MUCH),
        ("{% for i in range(999) %}{{ 'b' * 50 in value_json.s * 500 }}{% endfor %}", TOO_MUCH),
        ("{{ ('a' * 60000).strip('b' * 60000 ~ 'a') }}", TOO_MUCH),
        ("{{ (['b' * 500] * 100) | map('trim', 'c' * 60000) | list }}", TOO_MUCH),
        ("{{ (['b' * 100] * 600) | select('in', 'a' * 60000) | list }}", TOO_MUCH),
        ("{{ (['a'] * 1000) | sort(attribute='0.' * 20000 ~ '0') }}", "levels deep"),
        ("{{ range(4000) | select('search', 'x') | list }}", TOO_MUCH),
        ("{{ range(4000) | select('in', range(4000)) | list }}", TOO_MUCH),
        ("{{ range(4000) | map('map', 'string') | list }}", "no filter|" + TOO_MUCH),
        ("{% for i in range(4000) %}{{ value_json.l == value_json.l }}{% endfor %}", TOO_MUCH),
        ("{% for i in value_json.l %}{{ value_json.l | to_json | length }}{% endfor %}", TOO_MUCH),
        ("{{ 1 | pack('99999999999s') }}", "single values"),
        ("{{ [[]] | tojson(10**9) }}", "too far"),
        ("{{ 1e300 | timestamp_utc }}", "not a time"),
        ("{{ timedelta(days=1e300) }}", "fit"),
    ],
)
def test_unbounded_work_is_stopped(source: str, problem: str) -> None:
    with pytest.raises(TemplateError, match=problem):
        compile_template(source).render_value(PAYLOAD)


@pytest.mark.parametrize(
    "source",
    [
        "(" * 8000,
        "{{" * 4000,
        "{{ " + "(" * 4000,
        "{{ " + "not " * 2000 + "x }}",
        "{{ " + "-" * 1000 + "1 }}",
        "{{ x" + "|upper" * 400 + " }}",
        "{{ x" + ".a" * 400 + " }}",
        "{{ 1" + " and 1" * 200 + " }}",
        "{{ " + "1 if 1 else " * 100 + "1 }}",
        "{% if 1 %}" * 100 + "{% endif %}" * 100,
        "{#" * 4000,
        "{{ '" + "a" * 8000,
        "{% raw %}" * 900,
    ],
    ids=lambda source: str(source)[:20],
)
def test_a_source_that_is_deep_or_without_end_is_a_problem(source: str) -> None:
    assert compile_template(source).problem or compile_template(source).render({}) == source


def test_the_work_of_one_rendering_is_bounded_and_counted_anew() -> None:
    run = Run({})
    run.spend(MAX_STEPS)
    with pytest.raises(TemplateError, match=TOO_MUCH):
        run.spend(1)

    template = compile_template("{% for i in range(1000) %}x{% endfor %}")
    assert [len(template.render({})) for _ in range(20)] == [1000] * 20


def test_thousands_of_templates_that_read_one_message_share_their_work() -> None:
    """Each has enough for what templates of real devices do, and the next message is read anew."""
    hostile, honest = (compile_template(f"{{% for i in range({count}) %}}x{{% endfor %}}") for count in (1500, 20))
    for _ in range(2):
        begin_message()
        message = PayloadContext("1")
        for _ in range(6):
            hostile.render_value(message)
        for _ in range(20):
            with suppress(TemplateError):
                hostile.render_value(message)
        with pytest.raises(TemplateError, match=TOO_MUCH):
            hostile.render_value(message)
        assert honest.render_value(message) == "x" * 20
    work_left.set(None)


def test_the_output_is_bounded() -> None:
    assert len(compile_template("{{ 'x' * 65536 }}").render({})) == MAX_TEXT
    with pytest.raises(TemplateError, match="longer than"):
        compile_template("{{ 'x' * 65536 }}y").render({})
