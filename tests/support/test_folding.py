"""How words are compared."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.support.folding import MAX_WORD, fold, is_typo, words_of


def test_case_accents_and_separators_do_not_count() -> None:
    assert fold("  KÜCHEN-Lampe_1\n(Straße) ") == "kuchen lampe 1 (strasse)"
    assert words_of("KÜCHEN-Lampe_1 kuchen (Straße)") == ("kuchen", "lampe", "1", "strasse")


@pytest.mark.parametrize(
    ("word", "other", "expected"),
    [
        ("lampe", "lampe", False),
        ("lampe", "lampen", True),
        ("lampen", "lampe", True),
        ("lampe", "lempe", True),
        ("lampe", "lmape", True),
        ("lampe", "alampe", True),
        ("lampe", "lmpae", False),
        ("lamp", "limb", False),
        ("bad", "bed", False),
        ("desk", "desks1", False),
        ("4711", "4712", False),
        ("lamp1", "lamp2", False),
    ],
)
def test_one_typo_is_forgiven(word: str, other: str, *, expected: bool) -> None:
    assert is_typo(word, other) is expected


@given(st.text(max_size=500))
def test_words_are_bounded_and_stay_the_same_when_folded_again(text: str) -> None:
    for word in words_of(text):
        assert 0 < len(word) <= MAX_WORD
        assert fold(word) == word.replace("_", " ").strip()


@given(st.text("abc", max_size=6), st.text("abc", max_size=6))
def test_a_typo_is_the_same_both_ways(word: str, other: str) -> None:
    assert is_typo(word, other) == is_typo(other, word)
