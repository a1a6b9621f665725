"""The web client of the experiment (chapter 8), and what it saw; started by ``chapter8.py``."""

import os
import sys
import threading
import time
from collections import Counter

import light_service
import paho.mqtt.client as mqtt
import rclpy
from more_interfaces.msg import MqttGatewayIn
from more_interfaces.srv import DataRequest
from rclpy.node import Node

SAID = {  # five messages before the light service, and five after
    "home425/lights/roomlights405": ["on"] * 5 + ["on"] * 4 + ["off"],
    "home425/lights/philips165": ["off"] * 10,
    "home425/window/firstlevel1": ["open"] * 10,
}


class Witness(Node):
    """Counts what the gateway hears, and knows the graph."""

    def __init__(self):
        super().__init__("witness")
        self.heard = Counter()
        self.create_subscription(MqttGatewayIn, "gateway/mqtt/received_topics", self.on_topic, 100)
        self.index = self.create_client(DataRequest, "getIndexData")

    def on_topic(self, msg):
        self.heard[msg.data] += 1

    def spin_until(self, condition):
        deadline = time.monotonic() + 60
        while not condition() and time.monotonic() < deadline:
            rclpy.spin_once(self, timeout_sec=0.1)

    def entries(self, service_type):
        future = self.index.call_async(DataRequest.Request(servicetype=service_type))
        rclpy.spin_until_future_complete(self, future)
        return sorted(entry.elements[1] for entry in future.result().servicelist)


def say(client, messages):
    for number in range(*messages):
        for device, texts in SAID.items():
            client.publish(f"{device}/out", texts[number], qos=1).wait_for_publish(10)


def main():
    is_early = "--service-first" in sys.argv
    rclpy.init()
    witness, commands, subscribed = Witness(), Counter(), threading.Event()
    service = threading.Thread(target=light_service.main, daemon=True)
    client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
    client.on_subscribe = lambda *_: subscribed.set()
    client.on_message = lambda _client, _data, message: commands.update([message.topic.split("/")[2]])
    client.connect(os.environ["MQTT_HOST"], int(os.environ["MQTT_PORT"]))
    client.loop_start()
    client.subscribe("home425/+/+/in", qos=1)
    subscribed.wait(10)
    witness.spin_until(lambda: witness.count_subscribers("gateway/mqtt/out"))
    time.sleep(1.0)  # the gateway's client has subscribed as well
    if is_early:
        service.start()
    say(client, (0, 5))
    expected = 5 * is_early
    witness.spin_until(lambda: witness.heard.total() >= 15 and commands.total() >= expected)
    before = commands.copy()
    if not is_early:
        service.start()
        witness.spin_until(lambda: commands.total() >= 1)
    say(client, (5, 10))
    expected = before.total() + (4 if is_early else 5)
    witness.spin_until(lambda: witness.heard.total() >= 30 and commands.total() >= expected)
    end = time.monotonic() + 1.5
    witness.spin_until(lambda: time.monotonic() > end)  # no more comes
    after = commands - before
    topics = sorted(name for name, _ in witness.get_topic_names_and_types())
    echoes = sum(count for topic, count in witness.heard.items() if topic.endswith("/in"))
    window = next(kind for kind in ("lights", "window") if any("firstlevel1" in one for one in witness.entries(kind)))
    others = commands["philips165"] + commands["firstlevel1"]
    rows = [  # each is a fact of the thesis, with its place
        ("8", "messages that the gateway received, its own included", 30, witness.heard.total()),
        ("8.1, 8.3", "off to roomlights405, once the service is there", 4, after["roomlights405"]),
        ("8", "commands to other devices", 0, others),
        ("8.2", "the gateway hears its own messages", "yes", "yes" if echoes else "no"),
        ("listing 8.2", "firstlevel1 is in the index below", "lights", window),
        ("listing 8.4", "topics of the graph", 6, len(topics)),
    ]
    print(f"{'place':13}{'':54}{'thesis':8}here")
    for place, name, said, came in rows:
        print(f"{place:13}{name:54}{said!s:8}{came}")
    print(*topics, sep="\n", flush=True)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
