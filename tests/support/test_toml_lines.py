"""The line of a key in a file of TOML."""

import pytest

from homebot.support.toml_lines import line_of

FILE = """\
name = "villa"   # = no key
[gateways . "my broker"]
url = "mqtt://x"

[[routines]]
when = ["7:00"]
[[routines]]
do = [
    "wait = no key",  # ]
    { if = ["sun is down"], do = ["hall lamp on"] },

    "notify [[routines]]",
]
[routines.more]
dotted.key = 1
notes = [{ a = [1, 2] }, \"\"\"
two, lines\"\"\", 'x', 4.5,
    true]
"""


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("name", 1),
        ("gateways.my broker", 2),
        ("gateways.my broker.url", 3),
        ("gateways.my broker.user", 2),
        ("routines.0.when.0", 6),
        ("routines.1", 7),
        ("routines.1.do.0", 9),
        ("routines.1.do.1.do.0", 10),
        ("routines.1.do.2", 12),
        ("routines.1.do.7", 8),
        ("routines.2.when", 0),
        ("routines.more.dotted.key", 15),
        ("routines.more.notes.1", 16),
        ("routines.more.notes.2", 17),
        ("routines.more.notes.4", 18),
        ("routines.more.notes.5", 16),
        ("nothing", 0),
    ],
)
def test_a_key_has_its_line_or_that_of_what_is_around_it(path: str, line: int) -> None:
    assert line_of(FILE, *path.split(".")) == line


def test_a_file_that_is_cut_has_the_lines_before_the_cut() -> None:
    assert line_of(FILE[: FILE.index("{ if")], "routines", "1", "do", "1") == 8
