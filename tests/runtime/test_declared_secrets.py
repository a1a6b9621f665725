"""Each table says which of its keys are secrets, and nothing that homebot gives away has one."""

import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, get_args, get_origin

import pytest
from pydantic import BaseModel, SecretStr

from homebot.cli.commands.backup import write_backup
from homebot.config import Config, parse_config, parse_settings
from homebot.errors import ConfigError
from homebot.feature import feature_tables
from homebot.features.page.shown_addresses import shown
from homebot.graph import Graph, Node
from homebot.plugins import plugin_names
from homebot.recording.secrets import public_settings
from homebot.runtime.plan import GATEWAYS, plan_errors
from homebot.runtime.settings_parameters import declare_settings
from homebot.support.key_roles import KeyRole, declared_keys, is_secret_name, role_of, tables_read
from homebot.support.toml_text import toml_value

CANARY = "canary-4711"

TABLES: Mapping[str, Any] = {
    "home": {"name": "villa"},
    "gateways": {
        "mqtt": {"homeassistant": {}},
        "ble": {"devices": {"A4:C1:38:00:00:01": {}}, "proxies": [{"kind": "esphome", "address": "10.0.0.1"}]},
        "coap": {"credentials": [{"uri": "coap://10.0.0.2/*", "identity": "me", "key": "x"}]},
        "homeassistant": {},
        "homekit": {},
        "hue": {},
        "matter": {},
        "mdns": {
            "drivers": {
                "esphome": {"devices": {"a": {}}},
                "shelly": {},
                "homebot.integrations.things.driver:ThingDriver": {"credentials": [{"host": "a"}]},
            }
        },
        "nfc": {"tags": {}},
        "thing_directory": {"url": "https://dir", "credentials": [{"host": "dir", "scheme": "basic"}]},
        "homebot": {"token_file": "far"},
    },
    "apps": {"follow_me": {}, "lights_out": {}, "light_service": {}, "rmf_doors": {}, "window_heating": {}},
    "door": {"tokens": {"phone": {"token_file": "phone", "scope": ["read"]}}},
    "discovery": {"persist": True},
    "control": {"approvals": True},
    "notify": {"urls": ["ntfy://a"], "urls_by": {"high": ["ntfy://b"]}},
    "places": {"rooms": {"Hall": {}}},
    "devices": {"lamp": {}},
    "groups": [{"name": "all lamps", "members": "light"}],
    "robots": {"rosie": {}},
    "ros": {"listen": "tcp/127.0.0.1:7447"},
    "alerts": {"battery": "1h"},
    "helpers": {"mood": ["a", "b"]},
    "history": {"enabled": True},
    "homekit_bridge": {},
    "people": {"Anna": {"ping": "10.0.0.9"}},
    "pictures": {"Door": {"url": "http://camera/snapshot?user=a"}},
    "routines": [{"name": "r", "when": ["lamp1 on"], "do": ["lamp2 on"]}],
    "scenes": [{"name": "s", "values": {"lamp1": "on"}}],
}
"""All tables of the core, the features and the integrations, of which some lack a key: what is read counts."""


def models() -> Iterator[type[BaseModel]]:
    """Yield the models of all tables, and of the tables in them."""
    with tables_read() as tables:
        plan_errors(parse_config(TABLES, "test"))
    waiting, found = [model for _, model, _ in tables], set[type[BaseModel]]()
    while waiting:
        if (model := waiting.pop()) not in found:
            found.add(model)
            waiting += [one for field in model.model_fields.values() for one in models_in(field.annotation)]
    yield from sorted(found, key=lambda model: model.__qualname__)


def models_in(kind: Any) -> Iterator[type[BaseModel]]:
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        yield kind
    for part in get_args(kind):
        yield from models_in(part)


def value_of(kind: Any, leaf: Callable[[Any], object]) -> object:
    """Return a value of the type *kind* whose texts are the canary; None if it takes none."""
    origin, parts = get_origin(kind), get_args(kind)
    if kind in {str, SecretStr, Path, object}:
        return leaf(kind)
    if origin in {dict, Mapping}:
        inner = value_of(parts[1], leaf)
        return None if inner is None else {"high": inner}
    if origin in {tuple, list}:
        inner = value_of(parts[0], leaf)
        return None if inner is None else (inner,)
    return next((found for part in parts if (found := value_of(part, leaf)) is not None), None)


KEYS = [
    (model, field.alias or name, name)
    for model in models()
    for name, field in model.model_fields.items()
    if value_of(field.annotation, str) is not None
]


def test_the_tables_are_those_of_the_core_of_all_features_and_integrations() -> None:
    assert {*TABLES} == {*Config.model_fields, *feature_tables()} - {"features", "folder", "source"}
    assert {*TABLES["gateways"]} >= {*plugin_names(GATEWAYS)} - {"memory"}
    assert {*TABLES["gateways"]["mdns"]["drivers"]} >= {"esphome", "shelly"}
    assert len(KEYS) > 100


@pytest.mark.parametrize(("model", "key", "name"), KEYS, ids=lambda part: getattr(part, "__name__", part))
async def test_a_key_that_may_hold_a_secret_says_so_and_is_given_away_by_nothing(
    model: type[BaseModel], key: str, name: str
) -> None:
    field = model.model_fields[name]
    role = role_of(key, field)
    if role is KeyRole.PUBLIC:
        assert not is_secret_name(key)
        assert key not in {"url", "urls", "uri"} or (model.__name__, key) in WITHOUT_LOGIN
        return
    raw = value_of(field.annotation, lambda _: CANARY)
    declared = [(one.role, one.value) for one in declared_keys(model, {key: raw})]
    assert declared == [(role, CANARY)]
    if role is not KeyRole.SECRET:
        return
    held = value_of(field.annotation, lambda kind: SecretStr(CANARY) if kind is SecretStr else CANARY)
    settings = model.model_construct({name}, **{name: held})
    node = Node(Graph(), "node")
    declare_settings(node, settings)
    with pytest.raises(ConfigError) as wrong:
        parse_settings(model, {key: {"a": [[CANARY]]}}, "test", "table")
    given_away = [
        *(repr(node.get_parameter(one).value) for one in node.parameters.names()),
        repr(settings),
        repr(public_settings(settings)),
        repr(wrong.value),
        repr(shown(json.loads(json.dumps({key: raw})), {CANARY})),
    ]
    assert CANARY not in " ".join(given_away)


WITHOUT_LOGIN = {
    ("MatterGatewaySettings", "url"),  # with a user it is refused
    ("ThingDirectorySettings", "url"),  # likewise, and a query
}


def test_a_backup_without_secrets_has_none_of_any_table(tmp_path: Path) -> None:
    secrets = {
        "notify": {"urls_by": {"high": [f"ntfys://{CANARY}"]}},
        "pictures": {"Door": {"url": f"http://camera/snapshot?pwd={CANARY}"}},
        "door": {"token": CANARY},
        "gateways": {"mqtt": {"url": f"mqtt://robot:{CANARY}@broker"}},
        "unknown": {"acme_password": CANARY},
    }
    files = {
        "door": {"key": "secret", "certificate": "public"},
        "gateways": {"hue": {"pairings": "secret"}},
        "ros": {"cert_file": "secret"},
    }
    cases = [({key: table}, "homebot.toml") for key, table in secrets.items() if key != "unknown"]
    cases += [({key: table}, "secret") for key, table in files.items()]
    cases.append(({"gateways": {"acme": secrets["unknown"]}}, "homebot.toml"))
    cases.append(({"gateways": {"ble": {"devices": {"A4:C1:38:00:00:01": {"bind_key_file": "secret"}}}}}, "secret"))
    for number, (tables, left_out) in enumerate(cases):
        folder = tmp_path / str(number)
        (folder / "data" / "villa" / "copies").mkdir(parents=True)
        (folder / "secret").write_text(f"-----BEGIN PRIVATE KEY-----\n{CANARY}\n" if "ros" in tables else CANARY)
        (folder / "secret").chmod(0o600)
        (folder / "public").write_text("anybody may read this")
        (folder / "homebot.toml").write_text("\n".join(f"{key} = {toml_value(table)}" for key, table in tables.items()))
        manifest = write_backup(folder / "homebot.toml", folder / "data" / "villa" / "copies", folder / "villa.tar")
        assert manifest.left_out == (left_out,), tables
        assert CANARY.encode() not in (folder / "villa.tar").read_bytes()
