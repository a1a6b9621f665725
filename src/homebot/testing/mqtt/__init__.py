"""A real MQTT broker for tests: new for each test, observed, and failing on demand."""

from homebot.testing.mqtt.broker import BlockingTestBroker, TestBroker, serve_broker
from homebot.testing.mqtt.core import ClientView
from homebot.testing.mqtt.fault_control import BlockingFaults, Faults
from homebot.testing.mqtt.faults import Fault
from homebot.testing.mqtt.journal import RecordedMessage
from homebot.testing.mqtt.packet_log import PacketLog, PacketRecord, ProtocolViolation
from homebot.testing.mqtt.settings import BrokerSettings, TestTls
from homebot.testing.mqtt.thread import BrokerThread, broker_thread

__all__ = [
    "BlockingFaults",
    "BlockingTestBroker",
    "BrokerSettings",
    "BrokerThread",
    "ClientView",
    "Fault",
    "Faults",
    "PacketLog",
    "PacketRecord",
    "ProtocolViolation",
    "RecordedMessage",
    "TestBroker",
    "TestTls",
    "broker_thread",
    "serve_broker",
]
