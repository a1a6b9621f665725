"""Any configuration file: it is one, or a ConfigError names what is wrong."""

from contextlib import suppress
from pathlib import Path

from tests.fuzz.conftest import Fuzz

from homebot.config import load_config, parse_settings
from homebot.errors import ConfigError
from homebot.gateways.mqtt import MqttGatewaySettings

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
