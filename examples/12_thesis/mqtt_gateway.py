"""The gateway (listings 7.3 to 7.5): an MQTT client in a thread of its own, and a node that publishes what it hears."""

import os

import paho.mqtt.client as mqtt
import rclpy
from more_interfaces.msg import MqttGatewayIn, MqttGatewayOut, SubscriptionData
from more_interfaces.srv import SubscribeTopic
from paho.mqtt.subscribeoptions import SubscribeOptions
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

NEWEST = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
received = []


def on_connect(client, userdata, flags, reason_code, properties):
    client.subscribe("home425/#", options=SubscribeOptions(qos=1, noLocal=True))  # not what it sends itself


def on_subscribe(client, userdata, mid, reason_codes, properties):
    rclpy.logging.get_logger("mqtt_publisher").info("mqtt_publisher is connected")


def on_message(client, userdata, msg):
    received.append(msg)


class MqttPublisher(Node):
    def __init__(self, client):
        super().__init__("mqtt_publisher")
        self.client = client
        self.newest = {}
        self.data_publishers = {}
        self.publisher_ = self.create_publisher(MqttGatewayIn, "gateway/mqtt/received_topics", 10)
        self.subscription = self.create_subscription(MqttGatewayOut, "gateway/mqtt/out", self.send, 10)
        self.srv = self.create_service(SubscribeTopic, "subscribe_to_mqtt_topic", self.subscribe_topic)
        self.timer = self.create_timer(0.5, self.timer_callback)

    def timer_callback(self):
        if not received:
            return
        message = received.pop(0)
        self.newest[message.topic] = message
        self.get_logger().info(f"{message.topic}: {message.payload}")
        self.publisher_.publish(MqttGatewayIn(gateway="mqtt", data=message.topic))
        if message.topic in self.data_publishers:
            self.publish_data(message)

    def publish_data(self, message):
        data = SubscriptionData(topic=message.topic, data=str(message.payload))
        self.data_publishers[message.topic].publish(data)

    def send(self, msg):
        self.get_logger().info(f'Sending "{msg.data}" to {msg.topic}')
        self.client.publish(msg.topic, msg.data, qos=1)

    def subscribe_topic(self, request, response):
        response.data = "gateway/mqtt/received_data/" + request.topic.split("/")[2]
        if request.topic not in self.data_publishers:
            self.data_publishers[request.topic] = self.create_publisher(SubscriptionData, response.data, NEWEST)
            if request.topic in self.newest:  # the state of a device that a service meets
                self.publish_data(self.newest[request.topic])
        return response


def main(args=None):
    rclpy.init(args=args)
    client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, protocol=mqtt.MQTTv5)
    client.on_connect = on_connect
    client.on_message = on_message
    client.on_subscribe = on_subscribe
    client.connect(os.environ["MQTT_HOST"], int(os.environ["MQTT_PORT"]))
    client.loop_start()
    mqtt_publisher = MqttPublisher(client)
    rclpy.spin(mqtt_publisher)
    client.loop_stop()
    client.disconnect()
    mqtt_publisher.destroy_node()


if __name__ == "__main__":
    main()
