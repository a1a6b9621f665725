"""A new home begins with a file that its page fills, and a way to that page."""

import tomllib
from pathlib import Path

import pytest

from homebot.cli.arguments import ServerHost
from homebot.cli.new_home import begin_home, print_way_in
from homebot.config import load_config
from homebot.runtime.rosbridge_table import read_rosbridge_settings


@pytest.mark.parametrize(
    ("door", "has_token"), [(None, False), (ServerHost("127.0.0.1", 0), False), (ServerHost("192.0.2.7", 0), True)]
)
def test_the_file_of_a_new_home_is_valid_and_lets_others_in_by_a_token_alone(
    tmp_path: Path, door: ServerHost | None, has_token: object
) -> None:
    file = tmp_path / "homebot.toml"
    begin_home(file, door, tmp_path / "owner.token")
    settings = read_rosbridge_settings(load_config(file))
    assert (settings.token is not None) is has_token
    secret = settings.token.get_secret_value() if settings.token else ""
    assert settings.is_for_owner(secret)
    file.write_text("[home]\nname = 'Villa'")
    begin_home(file, door, tmp_path / "owner.token")
    assert tomllib.loads(file.read_text()) == {"home": {"name": "Villa"}}


@pytest.mark.newest("qr")
@pytest.mark.parametrize(
    ("page", "shown"),
    [
        ("http://127.0.0.1:9090", "http://127.0.0.1:9090/#code=ABCD2345"),
        ("https://192.0.2.7:9091", "https://192.0.2.7:9091/#code=ABCD2345"),
    ],
)
def test_the_owner_is_shown_the_address_and_the_code(capsys: pytest.CaptureFixture[str], page: str, shown: str) -> None:
    print_way_in(page, "ABCD2345")
    text = capsys.readouterr().out
    assert shown in text
    assert "ABCD-2345" in text
    assert ("█" in text or "[qr]" in text) is ("192" in page)
    print_way_in("http://0.0.0.0:9090", "ABCD2345")
    assert "0.0.0.0:9090/" not in capsys.readouterr().out
