"""A file of TOML is changed as its owner would: nothing else of it moves."""

import tomllib

import pytest
from tests.call_counts import calls

from homebot.errors import UsageError
from homebot.support.toml_edit import REMOVED, edit_toml

FILE = """\
# my house
door.port = 9090  # of the page
[home]
name = "Villa"   # as on the letter box # really

[gateways.mqtt]
url = "mqtt://broker"  # in the cellar
topics = [
    "a",
]

[gateways."my hue"]
[[groups]]
name = "x"
"""


@pytest.mark.parametrize(
    ("table", "values", "removed", "added"),
    [
        (
            ("home",),
            {"name": 'Villa "Sun"'},
            ['name = "Villa"   # as on the letter box # really'],
            ['name = "Villa \\"Sun\\""   # as on the letter box # really'],
        ),
        (("home",), {"language": "de"}, [], ['language = "de"']),
        (
            ("gateways", "mqtt"),
            {"act": True, "url": REMOVED},
            ['url = "mqtt://broker"  # in the cellar'],
            ["act = true"],
        ),
        (("gateways", "hue"), {"host": "10.0.0.2"}, [], ["", "[gateways.hue]", 'host = "10.0.0.2"']),
        (("gateways", "esphome"), {}, [], ["", "[gateways.esphome]"]),
        (("gateways", "my hue"), {"act": False}, [], ["act = false"]),
        (("gateways", "a b"), {"x y": 1}, [], ["", '[gateways."a b"]', '"x y" = 1']),
        (("home",), {"name": "Villa"}, [], []),
        (
            ("door",),
            {"port": 9091, "host": "::1"},
            ["door.port = 9090  # of the page"],
            ['door.host = "::1"', "door.port = 9091  # of the page"],
        ),
    ],
)
def test_one_line_changes(
    table: tuple[str, ...], values: dict[str, object], removed: list[str], added: list[str]
) -> None:
    lines, new = FILE.splitlines(), edit_toml(FILE, table, values)
    rest = [line for line in new.splitlines() if line not in added]
    assert rest == [line for line in lines if line not in removed and line not in added]
    assert [line for line in new.splitlines() if line in added and line] == [line for line in added if line]
    here = tomllib.loads(new)
    for name in table:
        here = here[name]
    assert {key: here.get(key, REMOVED) for key in values} == values


@pytest.mark.parametrize(
    ("table", "key"), [(("gateways", "mqtt"), "topics"), (("groups",), "name"), (("home", "name"), "x")]
)
def test_what_only_a_person_can_change_is_left(table: tuple[str, ...], key: str) -> None:
    with pytest.raises(UsageError, match=r"by hand|no table"):
        edit_toml(FILE, table, {key: "y"})


@pytest.mark.parametrize(
    ("text", "rest"),
    [
        ("a = 1\n\n[people.Anna]\nping = 'x'\n", "a = 1\n"),
        ("[people.Anna]\nping = 'x'\n\n# of Ben\n[people.Ben]\n", "\n# of Ben\n[people.Ben]\n"),
        ("[people]\nAnna.ping = 'x'\nBen.ping = 'y'\n", "[people]\nBen.ping = 'y'\n"),
    ],
)
def test_a_table_goes_with_its_lines_alone(text: str, rest: str) -> None:
    assert edit_toml(text, ("people",), {"Anna": REMOVED}) == rest


def test_an_empty_file_gets_its_first_table() -> None:
    assert edit_toml("", ("home",), {"name": "Villa"}) == '[home]\nname = "Villa"\n'


@pytest.mark.parametrize("quote", ['"', "'"])
def test_a_line_is_read_as_often_whatever_is_in_its_text(quote: str) -> None:
    """All before each # was read as TOML."""

    def count(length: int) -> int:
        return calls(lambda: edit_toml(f"a = {quote}{'#' * length}{quote} # x\n", (), {"a": 1}))

    assert count(400) < count(1) + 400


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('a = "#" # b', "a = 1 # b"),
        ('a = "\\"#"# b', "a = 1# b"),
        ("a = '\"#'  # b", "a = 1  # b"),
        ("a = '''it's # x''' # b", "a = 1 # b"),
        ('a = """say "#" """ # b', "a = 1 # b"),
        ("a = [ '#' ] # b # c", "a = 1 # b # c"),
    ],
)
def test_a_comment_begins_after_the_texts_of_its_line(old: str, new: str) -> None:
    assert edit_toml(f"{old}\n", (), {"a": 1}) == f"{new}\n"
