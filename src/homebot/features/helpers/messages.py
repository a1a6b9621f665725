"""The service that keeps the values of helpers."""

from typing import Annotated

from pydantic import Field

from homebot.devices.device import KeyValue
from homebot.messages.message import Message, ServiceAnswer, ServiceType


class KeepHelperValuesRequest(Message):
    """Request to keep values, by helper, beside those that are kept; none to read only."""

    values: Annotated[tuple[KeyValue, ...], Field(max_length=200)] = ()


class KeepHelperValuesResponse(ServiceAnswer):
    """All values that are kept, as JSON."""

    values: tuple[KeyValue, ...] = ()


KeepHelperValues = ServiceType("homebot/srv/KeepHelperValues", KeepHelperValuesRequest, KeepHelperValuesResponse)
