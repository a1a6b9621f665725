"""Who may connect."""

import pytest
from pydantic import SecretStr

from homebot.bridges.admission import name_of_token, refusal, token_of
from homebot.bridges.rosbridge import RosbridgeSettings

LOCAL = RosbridgeSettings()
NAMED = RosbridgeSettings(host="hub.lan", token=SecretStr("t"))
EVERYWHERE = RosbridgeSettings(host="0.0.0.0", token=SecretStr("t"))  # noqa: S104  # the case under test
PANEL = RosbridgeSettings(allowed_origins=("https://panel.example.org", "null"))
PROXY = RosbridgeSettings(allowed_origins=("https://house.example", "null"), token=SecretStr("t"))


@pytest.mark.parametrize(
    ("settings", "host", "origin"),
    [
        (LOCAL, "127.0.0.1:9090", ""),
        (LOCAL, "localhost", ""),
        (LOCAL, "LOCALHOST:1234", ""),
        (LOCAL, "[::1]:9090", ""),
        (LOCAL, "127.8.9.1", ""),
        (NAMED, "hub.lan:9090", ""),
        (EVERYWHERE, "192.168.1.5:9090", ""),
        (EVERYWHERE, "[fd00::1]:9090", ""),
        (PROXY, "house.example", ""),
        (LOCAL, "127.0.0.1:9090", "http://localhost:3000"),
        (LOCAL, "127.0.0.1:9090", "http://127.0.0.1"),
        (LOCAL, "127.0.0.1:9090", "http://[::1]:8080"),
        (PANEL, "127.0.0.1:9090", "https://panel.example.org"),
        (PANEL, "127.0.0.1:9090", "null"),
        (NAMED, "hub.lan:9090", "http://hub.lan"),
    ],
)
def test_a_client_that_calls_us_by_our_name_and_a_page_of_ours_are_let_in(
    settings: RosbridgeSettings, host: str, origin: str
) -> None:
    assert refusal(settings, [host], [origin] if origin else []) is None


@pytest.mark.parametrize(
    ("settings", "host"),
    [
        (LOCAL, "evil.example:9090"),
        (LOCAL, "127.0.0.1.evil.example"),
        (LOCAL, "192.168.1.5:9090"),
        (LOCAL, ""),
        (LOCAL, "[::1"),
        (LOCAL, "127.0.0.1?\udcb5"),
        (LOCAL, "127.0.0.1/x"),
        (LOCAL, "localhost@127.0.0.1"),
        (NAMED, "other.lan"),
        (EVERYWHERE, "evil.example"),
        (PANEL, "panel.example.org"),
        (PROXY, "evil.example"),
        (PROXY, "null"),
        (PROXY, ""),
    ],
)
def test_a_foreign_name_is_refused(settings: RosbridgeSettings, host: str) -> None:
    """DNS rebinding: the page's own name points to us."""
    problem = refusal(settings, [host], [])
    assert problem is not None
    assert "does not accept the host name" in problem


@pytest.mark.parametrize(
    "origin", ["https://evil.example", "http://localhost.evil.example", "null", "file://", "http://[", "", "nonsense"]
)
def test_a_foreign_page_is_refused(origin: str) -> None:
    problem = refusal(LOCAL, ["127.0.0.1:9090"], [origin])
    assert problem is not None
    assert "are not allowed" in problem


def test_doubled_headers_are_refused() -> None:
    assert refusal(LOCAL, ["127.0.0.1", "evil.example"], []) is not None
    assert refusal(LOCAL, [], []) is not None
    assert refusal(LOCAL, ["127.0.0.1"], ["http://localhost", "https://evil.example"]) is not None


def test_the_token_comes_in_the_header_or_in_the_query_of_a_websocket() -> None:
    assert token_of(["Bearer abc"]) == "abc"
    assert token_of([], "/?token=a%20b") == "a b"
    assert token_of(["bearer header"], "/?token=query") == "header"
    assert token_of(["Basic xyz"], "/?token=query") == "query"
    assert token_of([], "/") == token_of([]) == ""
    assert token_of([], "//[?token=x") == "x"


def test_only_the_right_token_opens() -> None:
    tokens = {"owner": SecretStr("t"), "robot": SecretStr("u")}
    assert name_of_token(tokens, "t") == "owner"
    assert name_of_token(tokens, "u") == "robot"
    assert name_of_token(tokens, "T") == ""
    assert name_of_token(tokens, "") == ""
    assert name_of_token(tokens, "\ud800é") == ""
