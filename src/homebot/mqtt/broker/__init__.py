"""An MQTT broker on asyncio, for tests and homes: 3.1, 3.1.1 and 5, using only the standard library.

Three parts: the codec (:mod:`homebot.mqtt.packets`), the broker's state without I/O (:class:`BrokerState` and its
parts), and the server (:class:`Broker`).
"""

from homebot.mqtt.broker.limits import BrokerLimits
from homebot.mqtt.broker.peer import Peer
from homebot.mqtt.broker.ports import BrokerPolicy, RefusedFilters, Transport
from homebot.mqtt.broker.server import Broker, PortTakenError
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.broker.stats import BrokerStats

__all__ = [
    "Broker",
    "BrokerLimits",
    "BrokerPolicy",
    "BrokerState",
    "BrokerStats",
    "Peer",
    "PortTakenError",
    "RefusedFilters",
    "Transport",
]
