"""Lists of links: what is read of them, what is refused."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.conventions.coap.link_writer import format_links

from homebot.conventions.coap.link_format import MAX_LINKS, WebLink, parse_links
from homebot.errors import WireError


@pytest.mark.parametrize(
    ("text", "links"),
    [
        ("", ()),
        (" \n", ()),
        (
            '</sensors>;ct=40;title="Sensor Index",</sensors/temp>;rt="temperature-c";if="sensor"',
            (
                WebLink("/sensors", (("ct", "40"), ("title", "Sensor Index"))),
                WebLink("/sensors/temp", (("rt", "temperature-c"), ("if", "sensor"))),
            ),
        ),
        (
            '<http://www.example.com/sensors/t123>;anchor="/sensors/temp";rel="describedby"',
            (WebLink("http://www.example.com/sensors/t123", (("anchor", "/sensors/temp"), ("rel", "describedby"))),),
        ),
        (
            "</a>;title=Sensor Index ;ct=0 41,</b>",
            (WebLink("/a", (("title", "Sensor Index"), ("ct", "0 41"))), WebLink("/b")),
        ),
        ("</a>; OBS ; ct = 50 , </b>", (WebLink("/a", (("obs", ""), ("ct", "50"))), WebLink("/b"))),
        ("</a>,", (WebLink("/a"),)),
        ("</a>,,</b> ,\n", (WebLink("/a"), WebLink("/b"))),
        (",</a>;,</b>;;obs;\r\n", (WebLink("/a"), WebLink("/b", (("obs", ""),)))),
        (r'</a>;title="a \"b\", <c>;d\\"', (WebLink("/a", (("title", r'a "b", <c>;d' + "\\"),)),)),
        (
            "</firmware/v2.1>;rt=\"firmware\";title*=UTF-8''x;sz=262144",
            (WebLink("/firmware/v2.1", (("rt", "firmware"), ("title*", "UTF-8''x"), ("sz", "262144"))),),
        ),
    ],
)
def test_links_are_read_as_rfc_6690_spells_them(text: str, links: tuple[WebLink, ...]) -> None:
    """Among them the examples of section 5."""
    assert parse_links(text.encode()) == links


@pytest.mark.parametrize(
    ("payload", "problem"),
    [
        (b"/light", "a link begins with <"),
        (b"<" + b"/" * 5, "a link begins with <"),
        (b"</a></b>", "a comma is expected"),
        (b"</a>;=b", "no name"),
        (b'</a>;title="x', "does not end"),
        (b"\xff", "not UTF-8"),
        (b"</a>," * MAX_LINKS + b"</a>", "more than 2000 links"),
        (b"</a>" + b";x" * 41, "more than 40 attributes"),
        (b"<" + b"a" * 300_000 + b">", "longer than 262144"),
    ],
)
def test_an_invalid_list_of_links_is_refused(payload: bytes, problem: str) -> None:
    with pytest.raises(WireError, match=problem):
        parse_links(payload)


def test_attributes_are_asked_for_by_name() -> None:
    (link,) = parse_links(b'</a>;rt="x y";rt=z;obs')
    assert (link.get("rt"), link.get("if"), link.words("rt")) == ("x y", "", ("x", "y", "z"))
    assert (link.has("obs"), link.has("ct")) == (True, False)


_names = st.from_regex(r"[a-z][a-z0-9-]{0,8}", fullmatch=True)
_values = st.text(st.characters(codec="utf-8", exclude_characters="\x00"), max_size=20)
_targets = st.text(st.characters(codec="utf-8", exclude_categories=["Cc"], exclude_characters="<>"), max_size=20)
_links = st.builds(WebLink, _targets, st.lists(st.tuples(_names, _values), max_size=5).map(tuple))


@given(st.lists(_links, max_size=5).map(tuple))
def test_written_values_are_read_again(links: tuple[WebLink, ...]) -> None:
    assert parse_links(format_links(links)) == links
