"""Names: rules, expansion and the escape."""

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from homebot.errors import InvalidNameError
from homebot.names import (
    escape_token,
    expand_name,
    full_node_name,
    is_hidden,
    unescape_token,
    validate_full_name,
    validate_namespace,
    validate_node_name,
)


@pytest.mark.parametrize("name", ["n", "_n", "Lamp_1", "n" * 255])
def test_a_node_name_of_letters_digits_and_underscores_is_legal(name: str) -> None:
    assert validate_node_name(name) == name


@pytest.mark.parametrize(
    ("name", "problem", "position"),
    [
        ("", "is empty", None),
        ("1n", "starts with a digit", 0),
        ("a/b", "has a character that is not allowed in names", 1),
        ("lämp", "has a character that is not allowed in names", 1),
        ("a٣", "has a character that is not allowed in names", 1),
        ("n\n", "has a character that is not allowed in names", 1),
        ("n" * 256, "is 256 characters long, over the limit of 255", None),
    ],
)
def test_an_illegal_node_name_is_refused_with_its_problem_and_place(
    name: str, problem: str, position: int | None
) -> None:
    with pytest.raises(InvalidNameError) as caught:
        validate_node_name(name)
    assert (caught.value.name, caught.value.problem, caught.value.position) == (name, problem, position)


def test_the_message_points_at_the_bad_character() -> None:
    with pytest.raises(InvalidNameError) as caught:
        validate_full_name("/kitchen lamp")
    assert str(caught.value) == (
        "topic name '/kitchen lamp' has a character that is not allowed in names at character 9 (' ')"
    )


@pytest.mark.parametrize("namespace", ["/", "/a", "/a/b_1", "/" + "a" * 244])
def test_a_namespace_is_absolute_and_has_no_trailing_slash(namespace: str) -> None:
    assert validate_namespace(namespace) == namespace


@pytest.mark.parametrize("namespace", ["", "a", "/a/", "//", "/a//b", "/1a", "/a b", "/" + "a" * 245])
def test_an_illegal_namespace_is_refused(namespace: str) -> None:
    with pytest.raises(InvalidNameError, match="namespace"):
        validate_namespace(namespace)


@pytest.mark.parametrize("name", ["/a", "/a/b", "/_a", "/a__b", "/" + "a" * 246])
def test_a_full_name_is_absolute(name: str) -> None:
    assert validate_full_name(name) == name


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("", "is empty"),
        ("a", "is not absolute"),
        ("/", "ends with a slash"),
        ("/a/", "ends with a slash"),
        ("//a", "has an empty token"),
        ("/a//b", "has an empty token"),
        ("/a/2b", "starts with a digit"),
        ("/a-b", "has a character"),
        ("/" + "a" * 247, "over the limit of 247"),
    ],
)
def test_an_illegal_full_name_is_refused(name: str, problem: str) -> None:
    with pytest.raises(InvalidNameError, match=problem):
        validate_full_name(name, "service name")


def test_length_is_checked_last() -> None:
    with pytest.raises(InvalidNameError, match="has a character"):
        validate_full_name("/" + "a" * 300 + "!")


@pytest.mark.parametrize(
    ("namespace", "full"),
    [("/", "/n"), ("", "/n"), ("/a", "/a/n"), ("a", "/a/n"), ("a/b", "/a/b/n")],
)
def test_a_node_stands_below_its_namespace(namespace: str, full: str) -> None:
    assert full_node_name("n", namespace) == full


@pytest.mark.parametrize(
    ("name", "namespace", "full"),
    [
        ("p", "/a", "/a/p"),
        ("/p", "/a", "/p"),
        ("~", "/a", "/a/n"),
        ("~/p", "/a", "/a/n/p"),
        ("p", "/", "/p"),
        ("~", "/", "/n"),
        ("~/p", "/", "/n/p"),
        ("{node}/p", "/a", "/a/n/p"),
        ("{ns}/p", "/a", "/a/p"),
        ("{namespace}/p", "/a/b", "/a/b/p"),
        ("{ns}/p", "/", "/p"),
        ("{ns}p", "/", "/p"),
        ("/x{ns}/p", "/", "/x/p"),
        ("/{node}_{node}", "/a", "/n_n"),
        ("~/{node}", "/a", "/a/n/n"),
    ],
)
def test_names_expand_as_in_ros(name: str, namespace: str, full: str) -> None:
    """The table of ROS 2's expansion rules, the root namespace included."""
    assert expand_name(name, "n", namespace) == full


@pytest.mark.parametrize(
    ("name", "problem", "position"),
    [
        ("", "is empty", None),
        ("p/", "ends with a slash", 4),
        ("a~", "has a tilde that is not at its start", 1),
        ("~~", "has a tilde that is not at its start", 1),
        ("~p", "has a tilde that is not followed by a slash", 1),
        ("{nod}", "has an unknown substitution {nod}", 0),
        ("{}", "has an unknown substitution {}", 0),
        ("{1}", "has an unknown substitution {1}", 0),
        ("{node}/{", "has an unmatched brace", 7),
        ("{node}}", "has an unmatched brace", 6),
        ("{{node}}", "has an unmatched brace", 0),
        ("{node}//x", "has an empty token", 5),
        ("{node}/2x", "has a token that starts with a digit", 5),
    ],
)
def test_a_name_that_cannot_expand_is_refused(name: str, problem: str, position: int | None) -> None:
    with pytest.raises(InvalidNameError) as caught:
        expand_name(name, "n", "/a")
    assert (caught.value.problem, caught.value.position) == (problem, position)


@pytest.mark.parametrize(
    ("name", "hidden"), [("/a", False), ("/_a", True), ("/a/_b/c", True), ("_a", True), ("/a_", False)]
)
def test_a_token_with_a_leading_underscore_hides_the_name(name: str, *, hidden: bool) -> None:
    assert is_hidden(name) is hidden


@pytest.mark.parametrize(
    ("text", "token"),
    [
        ("roomlights405", "roomlights405"),
        ("Küche 1", "K_xc3_xbcche_x201"),
        ("0x00158d", "x_0x00158d"),
        ("_hidden", "x__hidden"),
        ("x_", "x_x_"),
        ("a_x5f", "a_x5fx5f"),
        ("a/b", "a_x2fb"),
        ("é", "x__xc3_xa9"),
        ("a\n", "a_x0a"),
    ],
)
def test_odd_texts_are_escaped_as_documented(text: str, token: str) -> None:
    assert escape_token(text) == token
    assert unescape_token(token) == text


@given(st.text(min_size=1))
@example("_x5f")
@example("x_x41")
@example("__x41")
@example("_xé")
@example("x_é")
@example("_x_x5fx5f")
def test_any_text_becomes_a_legal_visible_token_and_comes_back(text: str) -> None:
    token = escape_token(text)
    assert unescape_token(token) == text
    assert not is_hidden(token)
    validate_node_name(token[:255])


@given(st.text("_x05fa ", min_size=1), st.text("_x05fa ", min_size=1))
def test_two_texts_never_share_a_token(one: str, other: str) -> None:
    assert (escape_token(one) == escape_token(other)) == (one == other)


def test_an_empty_text_has_no_token() -> None:
    with pytest.raises(InvalidNameError, match="is empty"):
        escape_token("")


def test_a_lone_surrogate_has_no_token() -> None:
    with pytest.raises(InvalidNameError, match="is not valid Unicode at character 2"):
        escape_token("a\ud800")


def test_an_escape_that_spells_no_text_is_refused() -> None:
    with pytest.raises(InvalidNameError, match="does not decode to UTF-8"):
        unescape_token("a_xff")
