"""Pages of other origins in a browser, which lets them do as the answers of the directory say."""

import pytest
from tests.bridges.thing_directory.conftest import OpenHouse, ServedHouse

from homebot.bridges.thing_directory.documents import sharing_headers

PAGE = "http://localhost:3000"


async def headers_of(
    house: ServedHouse, method: str, path: str, origin: str, **headers: str
) -> tuple[int, dict[str, str]]:
    """Return the status, and the header fields about sharing."""
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    async with house.client.request(method, f"{house.url}{path}", headers={"Origin": origin, **named}) as answer:
        found = {
            name: value for name, value in answer.headers.items() if name.startswith("Access-Control") or name == "Vary"
        }
        return answer.status, found


async def test_a_page_that_is_let_in_may_read_the_answers_and_their_headers(house: ServedHouse) -> None:
    for path, status in (("/things", 200), ("/.well-known/wot", 200), ("/events", 200), ("/nowhere", 404)):
        assert await headers_of(house, "GET", path, PAGE) == (
            status,
            {
                "Access-Control-Allow-Origin": PAGE,
                "Access-Control-Expose-Headers": "Allow, ETag, Link, Retry-After",
                "Vary": "Origin",
            },
        )


async def test_a_preflight_is_answered_with_the_allowed_headers_and_needs_no_token(served_house: OpenHouse) -> None:
    """It asks before each PUT, and before each request with a token; it cannot show the token then."""
    async with served_house(token="sesame") as house:
        path = "/things/urn%3Ax/properties/on_off"
        status, headers = await headers_of(house, "OPTIONS", path, PAGE, Access_Control_Request_Method="PUT")
        assert status == 204
        assert headers["Access-Control-Allow-Origin"] == PAGE
        assert headers["Access-Control-Allow-Methods"] == "GET, HEAD, PUT"
        assert headers["Access-Control-Allow-Headers"].startswith("Authorization, Content-Type, ")
        assert (await headers_of(house, "PUT", path, PAGE))[0] == 401
        assert (await headers_of(house, "OPTIONS", path, PAGE))[0] == 401


@pytest.mark.parametrize("origin", ["https://evil.example", "null"])
async def test_a_page_that_is_not_let_in_is_told_nothing(house: ServedHouse, origin: str) -> None:
    assert await headers_of(house, "GET", "/things", origin) == (403, {})
    assert (await house.get("/things", Host="evil.example"))[0] == 403
    asked = await headers_of(house, "OPTIONS", "/things", origin, Access_Control_Request_Method="PUT")
    assert asked == (403, {})


async def test_the_pages_of_the_configuration_are_let_in(served_house: OpenHouse) -> None:
    async with served_house(allowed_origins=("https://panel.example", "null")) as house:
        for origin in ("https://panel.example", "null"):
            status, headers = await headers_of(house, "GET", "/things", origin)
            assert (status, headers["Access-Control-Allow-Origin"]) == (200, origin)


async def test_a_program_that_is_no_page_is_told_nothing_about_sharing(house: ServedHouse) -> None:
    async with house.client.get(f"{house.url}/things") as answer:
        assert not [name for name in answer.headers if name.startswith("Access-Control")]


@pytest.mark.parametrize(
    "origins", [[], ["http://a", "http://b"], ["http://localhost/\udcff"], ["http://localhost/\x01"]]
)
def test_an_invalid_origin_is_not_repeated(origins: list[str]) -> None:
    assert sharing_headers(origins) == {}
