"""Names that somebody may have meant."""

from homebot.support.names import did_you_mean, similar_to


def test_the_likeliest_comes_first() -> None:
    assert similar_to("lihgt", ["plug", "light", "lights"])[0] == "light"


def test_a_piece_of_a_name_is_like_it() -> None:
    assert similar_to("/out", ["/gateway/mqtt/out", "/rosout_of_reach_of_all", "/tick"]) == [
        "/gateway/mqtt/out",
        "/rosout_of_reach_of_all",
    ]


def test_where_nothing_is_similar_the_hint_is_another() -> None:
    assert did_you_mean("keepalive", ["keep_alive", "user"], "there are two") == "did you mean keep_alive?"
    assert did_you_mean("colour", ["keep_alive", "user"], "there are two") == "there are two"


def test_case_and_accents_make_no_difference() -> None:
    assert similar_to("DESK-LMP", ["Désk lamp", "plug"]) == ["Désk lamp"]


def test_names_that_differ_in_case_alone_are_one() -> None:
    assert similar_to("desk lmp", ["desk_lamp", "Desk lamp"]) == ["Desk lamp"]
