"""Tables for people."""

from __future__ import annotations

from homebot.cli.table import to_table


def test_columns_are_as_wide_as_they_need_to_be() -> None:
    assert to_table(("A", "B"), [("long", "x"), ("s", "y")]) == "A     B\nlong  x\ns     y"


def test_an_endless_cell_is_cut_and_spoils_no_other_row() -> None:
    assert to_table(("ID", "B"), [("x" * 30_000, "y")]) == f"ID{' ' * 48}B\n{'x' * 47}…  y"
    assert to_table(("ID",), [("x" * 48,)]) == f"ID\n{'x' * 48}"


def test_control_characters_are_shown_and_count_as_they_are_shown() -> None:
    assert to_table(("ID",), [("a\x1b[31m",)]) == "ID\na\\x1b[31m"
    assert to_table(("ID",), [("\x1b" * 40,)]) == "ID\n" + ("\\x1b" * 12)[:47] + "…"
