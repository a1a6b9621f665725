"""Listings 7.3 to 7.5: an MQTT client in a thread of its own, and a node with publishers made when asked for."""

import os

import paho.mqtt.client as mqtt
import rclpy
from more_interfaces.msg import MqttGatewayIn, MqttGatewayOut, SubscriptionData
from more_interfaces.srv import SubscribeTopic
from rclpy.node import Node

received = []


def on_connect(client, userdata, flags, reason_code, properties):
    client.subscribe("home425/#", qos=1)


def on_subscribe(client, userdata, mid, reason_codes, properties):
    rclpy.logging.get_logger("mqtt_publisher").info("mqtt_publisher is connected")


def on_message(client, userdata, msg):
    received.append(msg)


class MqttPublisher(Node):
    def __init__(self, client):
        super().__init__("mqtt_publisher")
        self.client = client
        self.data_publishers = {}
        self.publisher_ = self.create_publisher(MqttGatewayIn, "gateway/mqtt/received_topics", 10)
        self.subscription = self.create_subscription(MqttGatewayOut, "gateway/mqtt/out", self.send, 10)
        self.srv = self.create_service(SubscribeTopic, "subscribe_to_mqtt_topic", self.subscribe_topic)
        self.timer = self.create_timer(0.02, self.timer_callback)

    def timer_callback(self):
        if not received:
            return
        message = received.pop(0)
        msg = MqttGatewayIn()
        msg.gateway = "mqtt"
        msg.data = message.topic
        self.publisher_.publish(msg)
        if message.topic in self.data_publishers:
            data = SubscriptionData()
            data.topic = message.topic
            data.data = str(message.payload)
            self.data_publishers[message.topic].publish(data)

    def send(self, msg):
        self.get_logger().info(f'Sending "{msg.data}" to {msg.topic}')
        self.client.publish(msg.topic, msg.data, qos=1)

    def subscribe_topic(self, request, response):
        name = "gateway/mqtt/received_data/" + request.topic.split("/")[2]
        if request.topic not in self.data_publishers:
            self.data_publishers[request.topic] = self.create_publisher(SubscriptionData, name, 10)
        response.data = name
        return response


def main(args=None):
    rclpy.init(args=args)
    client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
    client.on_connect = on_connect
    client.on_message = on_message
    client.on_subscribe = on_subscribe
    client.connect("127.0.0.1", int(os.environ["MQTT_PORT"]))
    client.loop_start()
    mqtt_publisher = MqttPublisher(client)
    rclpy.spin(mqtt_publisher)
    client.loop_stop()
    client.disconnect()
    mqtt_publisher.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
