"""The parts of a Tasmota device: lamps, relays, shutters, a fan, inputs and sensors. Pure.

Source: hatasmota 0.10.2, ``discovery.py``.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain

from homebot.conventions.description import DescribedPart
from homebot.conventions.part_builder import PartBuilder, with_own_ids
from homebot.conventions.table_codec import json_object
from homebot.conventions.tasmota.config import LIGHT, RELAY, TasmotaConfig
from homebot.conventions.tasmota.device_topics import TasmotaTopics
from homebot.conventions.tasmota.fan import add_fan
from homebot.conventions.tasmota.inputs import describe_inputs
from homebot.conventions.tasmota.light import add_light
from homebot.conventions.tasmota.sensors import Leaf, describe_sensors
from homebot.conventions.tasmota.shutter import add_shutter, count_shutters

__all__ = ["build_parts"]


def build_parts(config: TasmotaConfig, leaves: Iterable[Leaf]) -> tuple[DescribedPart, ...]:
    """Describe the parts of a device, each id once.

    The first relay of an iFan is its lamp. The others make the speeds of its fan: they are told, and nobody switches
    one of them alone, as Home Assistant would let people do.
    """
    topics = TasmotaTopics(config)
    described = chain(_outputs(topics), describe_inputs(topics), describe_sensors(topics, leaves))
    return with_own_ids(described, _MOST_PARTS)


_MOST_PARTS = 500

_LAMPS_OPTION = 30
"""SetOption30: the user says that lamps hang on the relays."""


def _outputs(topics: TasmotaTopics) -> Iterable[DescribedPart]:
    config = topics.config
    for index, output in enumerate(config.outputs):
        name = config.output_name(index)
        if config.is_fan and output in (RELAY, LIGHT):
            yield _relay(topics, index, "light", name) if index == 0 else _relay_of_fan(topics, index, name)
        elif output == LIGHT:
            part = PartBuilder(json_object, f"light_{index + 1}", "light", name=name, advertised="light")
            add_light(part, topics, index)
            yield part.build()
        elif output == RELAY:
            yield _relay(topics, index, "light" if config.option(_LAMPS_OPTION) else "switch", name)
    for index in range(count_shutters(config.outputs)):
        part = PartBuilder(json_object, f"shutter_{index + 1}", "window_covering", advertised="shutter", tag="shutter")
        add_shutter(part, topics, index)
        yield part.build()
    if config.is_fan:
        part = PartBuilder(json_object, "fan", "fan", advertised="fan")
        add_fan(part, topics)
        yield part.build()


def _relay(topics: TasmotaTopics, index: int, service_type: str, name: str) -> DescribedPart:
    part = PartBuilder(json_object, f"power_{index + 1}", service_type, name=name, advertised="relay")
    topics.add_power_switch(part, index)
    return part.build()


def _relay_of_fan(topics: TasmotaTopics, index: int, name: str) -> DescribedPart:
    part = PartBuilder(
        json_object, f"power_{index + 1}", "x_binary_sensor", name=name, advertised="relay", category="diagnostic"
    )
    topics.add_power_state(part, index)
    return part.build()
