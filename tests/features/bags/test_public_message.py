"""No secret of a device reaches a bag."""

import pytest
from tests.features.bags.bags import START, topic, words

from homebot.devices import RawCommand, RawMessage
from homebot.features.bags.bag_topic import BagMessage
from homebot.features.bags.public_message import without_raw_secrets
from homebot.messages import Time
from homebot.messages.cdr import message_from_cdr, message_to_cdr

RAW = RawMessage(
    gateway="mqtt", key="lock", address="lock", payload=b"", retained=False, received_at=Time.from_seconds(1)
)
COMMAND = RawCommand(address="lock/set", payload="")


@pytest.mark.parametrize("message", [RAW, COMMAND], ids=["RawMessage", "RawCommand"])
def test_secrets_in_the_payload_of_a_raw_message_are_hidden(message: RawMessage | RawCommand) -> None:
    payload = '{"pin_code":"4711","state":"LOCK"}'
    given = message.model_copy(update={"payload": payload if isinstance(message, RawCommand) else payload.encode()})
    sent = BagMessage(topic("/raw", type(given)), START, message_to_cdr(given))
    cleaned = without_raw_secrets(sent)
    found = message_from_cdr(type(given), cleaned.data)
    hidden = '{"pin_code":"***","state":"LOCK"}'
    assert found.payload == (hidden if isinstance(found, RawCommand) else hidden.encode())


def test_other_messages_stay_as_they_are() -> None:
    (message,) = words(1)
    assert without_raw_secrets(message) is message
