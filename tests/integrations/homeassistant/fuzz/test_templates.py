"""Any templates with any values: a text, or a TemplateError."""

from contextlib import suppress

from tests.fuzz.conftest import Fuzz
from tests.integrations.real_devices import rows_of

from homebot.integrations.homeassistant.formats.jinja import TemplateError, compile_template
from homebot.integrations.homeassistant.formats.jinja.functions import FILTERS, FUNCTIONS
from homebot.integrations.homeassistant.formats.jinja.lists import CHECKS
from homebot.integrations.homeassistant.formats.jinja.texts import METHODS

SIGNS = r"- value_json value . | [ ] ( ) { } : , ' + * ** / % ~ == < a 1 2.5 \ é 1e9 _ *a range(3) loop.index"
WORDS = "{{ }} {% %} if else elif endif for in endfor set is not and none"
PIECES = (
    *SIGNS.split(),
    *(f" {word} " for word in WORDS.split()),
    *("9" * 30, "\n", "\ud800"),
    *(f"| {name}" for name in FILTERS),
    *(f"is {name} " for name in CHECKS),
    *(f"{name}(" for name in FUNCTIONS),
)

CALLS = (
    *("{{ a[b] }}", "{{ a[b:x] }}", "{{ {a: b} }}", "{{ -a }}", "{{ +a }}", "{% for x, y in a %}{{ x }}{% endfor %}"),
    *(
        f"{{{{ a {operator} b }}}}"
        for operator in ("+", "-", "*", "/", "//", "%", "**", "~", "<", "==", "in", "not in")
    ),
    *(f"{{{{ a | {name}(ARGUMENTS) }}}}" for name in FILTERS),
    *(f"{{{{ a | map('{name}', b) | list }}}}" for name in FILTERS),
    *(f"{{{{ a is {name}(ARGUMENTS) }}}}" for name in CHECKS if name.isidentifier()),
    *(f"{{{{ a | select('{name}', b) | list }}}}" for name in CHECKS),
    *(f"{{{{ {name}(ARGUMENTS) }}}}" for name in FUNCTIONS),
    *(f"{{{{ a.{name}(ARGUMENTS) }}}}" for methods in METHODS.values() for name in methods),
)
ARGUMENTS = ("", "a", "b", "a, b", "b, x", "b, x, a", "x=b")
TEXTS = ("%d", "{0}", "[", "a*", "2024-01-01", "utf-8", ">I", "b", "%s%s")


def sources() -> list[str]:
    """The templates of real announcements."""
    texts = [text for row in rows_of("homeassistant") for _, text in row["messages"]]
    return sorted({text.split('"')[1] for line in texts for text in line.split("template") if text.count('"') > 1})


def test_any_template_gives_a_text_or_says_why_not(fuzz: Fuzz) -> None:
    real = [one for one in sources() if "{" in one] or ["{{ value_json.a | float(0) * 2 }}"]

    for mutate, rng in fuzz("templates"):
        if rng.random() < 0.5:
            source = "".join(rng.choice(PIECES) for _ in range(rng.randrange(1, 25)))
        else:
            source = mutate.damaged_text(rng.choice(real))
        variables = {name: mutate.value() for name in ("value_json", "value", "a", "b")}
        with suppress(TemplateError):
            assert isinstance(compile_template(source).render(variables), str)
        with suppress(TemplateError):
            assert isinstance(compile_template(source).render_value(mutate.word()), str)


def test_any_function_takes_any_values(fuzz: Fuzz) -> None:
    for mutate, rng in fuzz("functions of templates", TEXTS):
        template = compile_template(rng.choice(CALLS).replace("ARGUMENTS", rng.choice(ARGUMENTS)))
        assert template.problem == ""
        with suppress(TemplateError):
            text = template.render({name: mutate.value() for name in "abx"})
            assert len(text.encode()) >= len(text)
