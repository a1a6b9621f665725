"""Secrets are no part of a recording."""

import json

import pytest
from pydantic import BaseModel, SecretStr

from homebot.recording.secrets import public_settings, without_secrets
from homebot.replay.replay_people import OWNER_SERVICES
from homebot.support.key_roles import is_secret_name


class AppTable(BaseModel):
    quiet_after: float = 600.0
    rooms: tuple[str, ...] = ()
    alarm_code: str = ""
    login: SecretStr = SecretStr("")
    services: dict[str, str] = {}


def test_settings_are_those_that_were_set_without_the_secret_ones() -> None:
    table = AppTable(
        quiet_after=60.0, alarm_code="1234", login=SecretStr("hidden"), services={"api_key": "x", "url": "http://a"}
    )
    assert public_settings(table) == {"quiet_after": 60.0, "services": {"api_key": "***", "url": "http://a"}}


def test_a_login_in_a_url_is_hidden() -> None:
    table = AppTable(services={"url": "mqtt://anna:geheim@broker:1883/a@b", "mail": "anna@example.org"})
    assert public_settings(table) == {"services": {"url": "mqtt://***@broker:1883/a@b", "mail": "anna@example.org"}}


def test_no_request_of_the_owner_has_a_secret_field() -> None:
    """They are recorded as they are; the key of an announcement is none."""
    names = [field for service in OWNER_SERVICES.values() for field in service.Request.model_fields]
    assert [name for name in names if is_secret_name(name)] == ["key"]


@pytest.mark.parametrize("name", ["code", "PIN", "wifi_password", "api-key", "action_code", "access token"])
def test_names_of_secrets(name: str) -> None:
    assert is_secret_name(name)


@pytest.mark.parametrize("name", ["on", "spin", "keyboard", "encoded", "color_mode", "state"])
def test_names_of_what_is_no_secret(name: str) -> None:
    assert not is_secret_name(name)


def test_a_raw_message_keeps_all_but_its_secrets() -> None:
    found = without_secrets(b'{"action": "disarm", "action_code": "1234", "users": [{"pin": 1, "name": "Anna"}]}')
    assert json.loads(found) == {
        "action": "disarm",
        "action_code": "***",
        "users": [{"pin": "***", "name": "Anna"}],
    }


@pytest.mark.parametrize("payload", [b"on", b"\xff\x00", b'{"on": true}', b"{broken", b"", b"[" * 100_000])
def test_a_message_without_secrets_stays_as_it_is(payload: bytes) -> None:
    assert without_secrets(payload) == payload
