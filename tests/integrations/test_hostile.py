"""Long, deep and odd messages are refused in few words, or mean nothing."""

from collections.abc import Callable, Mapping

import pytest

from homebot.conventions.convention import Convention
from homebot.conventions.description import AnnouncementEvent
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings
from homebot.integrations.homie.formats import Homie, HomieSettings
from homebot.integrations.shelly.formats import Shelly, ShellySettings
from homebot.integrations.tasmota.formats import TasmotaDiscovery, TasmotaSettings
from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings

TOPICS: Mapping[str, Callable[[], Convention]] = {
    **dict.fromkeys(("homie/5/x/$description", "homie/x/$nodes"), lambda: Homie(HomieSettings())),
    **dict.fromkeys(("homebot/x/rpc", "x/events/rpc", "shellies/announce"), lambda: Shelly(ShellySettings())),
    **dict.fromkeys(
        [f"tasmota/discovery/2462AB000011/{kind}" for kind in ("config", "sensors")],
        lambda: TasmotaDiscovery(TasmotaSettings()),
    ),
    "zigbee2mqtt/bridge/devices": lambda: Zigbee2Mqtt(Zigbee2MqttSettings()),
    **dict.fromkeys(
        [f"homeassistant/{kind}/x/config" for kind in ("switch", "device")],
        lambda: HomeAssistantDiscovery(HomeAssistantSettings()),
    ),
}
MAY_BE_OTHERS = {"homie/x/$nodes", "x/events/rpc"}
"""Plain text, and topics of other programs."""

PAYLOADS = {
    "junk": b"x" * 5_000_000,
    "open": b'{"a":' * 10_000,
    "objects": b"{" * 5_000_000,
    "deep": b"[" * 10_000 + b"]" * 10_000,
    "long": b" " * (32 * 1024 * 1024) + b"[]",
    "NaN": b'{"a": NaN}',
    "surrogate": b'["\\ud800"]',
}


@pytest.mark.parametrize("payload", PAYLOADS.values(), ids=PAYLOADS)
@pytest.mark.parametrize("topic", TOPICS)
def test_an_attack_is_refused_in_few_words(topic: str, payload: bytes) -> None:
    convention = TOPICS[topic]()
    found: tuple[AnnouncementEvent, ...] = ()
    problem = ""
    try:
        found = convention.read_message(topic, payload, retained=False)
    except WireError as error:
        problem = str(error)
    assert (found, convention.rejected) == ((), int(problem != ""))
    assert len(problem) < 400
    assert problem or topic in MAY_BE_OTHERS
