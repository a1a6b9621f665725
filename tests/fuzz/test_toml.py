"""Any configuration file: it is one, or a ConfigError names what is wrong."""

import re
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

from tests.fuzz.conftest import Fuzz

from homebot.config import load_config, parse_config, parse_settings
from homebot.errors import ConfigError
from homebot.gateways.mqtt import MqttGatewaySettings
from homebot.runtime import make_plan

WHOLE = """\
[home]
name = "villa"

[gateways.mqtt]
url = "mqtts://broker.example:8883"
root = "home425"
user = "robot"
act = true
delivery = "inbox"
max_payload = 1000
stale_after = 3.5
conventions = ["thesis", "homeassistant"]
homeassistant = { prefix = "ha", publish = true }

[apps.light_service]

[apps.mine]
class = "my:App"
x = 1

[door]
port = 9090
host = "127.0.0.1"

[discovery]
"""
LINES = WHOLE.splitlines()
DOCS = Path(__file__).parents[2] / "docs"


def shown_in_docs() -> list[str]:
    """Return the configurations that the docs show."""
    texts = [page.read_text("utf-8") for page in sorted(DOCS.glob("*.md"))]
    return [block for text in texts for block in re.findall(r"```toml\n(.*?)```", text, re.DOTALL)]


def places_in(value: Any) -> Iterator[tuple[Any, Any]]:
    """Yield each table and array in *value* with each of its keys."""
    for key, inner in value.items() if isinstance(value, dict) else enumerate(value if isinstance(value, list) else ()):
        yield value, key
        yield from places_in(inner)


def test_any_file_is_a_configuration_or_refused(fuzz: Fuzz, tmp_path: Path) -> None:
    file = tmp_path / "homebot.toml"

    for mutate, rng in fuzz("toml", LINES):
        lines = [line for line in LINES if rng.random() < 0.9]
        for _ in range(rng.choice((0, 1, 2))):
            lines.insert(rng.randrange(len(lines) + 1), f"{mutate.word()} = {mutate.value()!r}")
        raw = "\n".join(lines).encode(errors="surrogatepass")
        file.write_bytes(mutate.damaged_bytes(raw) if rng.random() < 0.7 else raw)
        with suppress(ConfigError):
            config = load_config(file)
            parse_settings(MqttGatewaySettings, config.gateways.get("mqtt", {}), str(file), "gateways.mqtt")


def test_any_value_in_a_table_of_the_docs_is_planned_or_refused(fuzz: Fuzz, tmp_path: Path) -> None:
    """Control ended by the rights of a wrong app, and a list for the class of a gateway was a TypeError."""
    shown = shown_in_docs()

    for mutate, rng in fuzz("configuration", LINES):
        tables = tomllib.loads(rng.choice(shown))
        holder, key = rng.choice([*places_in(tables)])
        if (value := mutate.value()) is None:
            del holder[key]
        else:
            holder[key] = value
        with suppress(ConfigError):
            plan = make_plan(parse_config(tables, "homebot.toml", tmp_path))
            assert plan.scopes.keys() >= {"door.scope"}
