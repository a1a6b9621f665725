"""Tables for people."""

from __future__ import annotations

from homebot.cli.terminal import to_lines, to_table, without_empty


def test_columns_are_as_wide_as_they_need_to_be() -> None:
    assert to_table(("A", "B"), [("long", "x"), ("s", "y")]) == "A     B\nlong  x\ns     y"


def test_an_endless_cell_is_cut_and_spoils_no_other_row() -> None:
    assert to_table(("ID", "B"), [("x" * 30_000, "y")]) == f"ID{' ' * 48}B\n{'x' * 47}…  y"
    assert to_table(("ID",), [("x" * 48,)]) == f"ID\n{'x' * 48}"


def test_control_characters_are_shown_and_count_as_they_are_shown() -> None:
    assert to_table(("ID",), [("a\x1b[31m",)]) == "ID\na\\x1b[31m"
    assert to_table(("ID",), [("\x1b" * 40,)]) == "ID\n" + ("\\x1b" * 12)[:47] + "…"


def test_lines_may_be_of_different_lengths() -> None:
    """The last cell of a row makes no column wider."""
    assert to_lines([("a", "long value that ends the line"), ("bc", "x", "y"), ()]) == [
        "a   long value that ends the line",
        "bc  x  y",
        "",
    ]
    assert to_lines([("x" * 300,)]) == [f"{'x' * 199}…"]


def test_columns_that_may_be_empty_are_left_out_where_they_are() -> None:
    assert without_empty({"B", "C"}, ("A", "B", "C"), [("1", "", "x"), ("", "", "")]) == (
        ["A", "C"],
        [["1", "x"], ["", ""]],
    )
