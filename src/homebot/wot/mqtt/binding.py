"""The choice among the forms of an affordance that MQTT makes. Pure."""

from __future__ import annotations

from homebot.wot import Affordance, Form, PayloadFormats, basic_formats

__all__ = ["MqttBinding"]

_OBSERVE_OPS = frozenset({"readproperty", "observeproperty", "subscribeevent"})
_WRITE_OPS = frozenset({"writeproperty", "invokeaction"})


class MqttBinding:
    """The forms with topics: whoever subscribes is sent the values.

    Args:
        formats: The formats of payloads that count; forms with any other are none.

    Attributes:
        formats: The same.
    """

    def __init__(self, formats: PayloadFormats = basic_formats) -> None:
        self.formats = formats

    def observe_forms(self, affordance: Affordance) -> tuple[Form, ...]:
        """Return the forms with a filter to subscribe to."""
        return tuple(
            one
            for one in affordance.forms
            if one.is_mqtt and one.filter and not _OBSERVE_OPS.isdisjoint(one.ops) and self.formats(one.content_type)
        )

    def write_forms(self, affordance: Affordance) -> tuple[Form, ...]:
        """Return the forms with a topic to publish on."""
        return tuple(
            one
            for one in affordance.forms
            if one.is_mqtt and one.topic and not _WRITE_OPS.isdisjoint(one.ops) and self.formats(one.content_type)
        )
