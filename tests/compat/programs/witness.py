"""Prints the topics that exist whenever a command is sent."""

import rclpy
from more_interfaces.msg import MqttGatewayOut
from rclpy.node import Node


def main():
    rclpy.init()
    node = Node("witness")

    def show(msg):
        print(*(name for name, _ in node.get_topic_names_and_types()), flush=True)

    node.create_subscription(MqttGatewayOut, "gateway/mqtt/out", show, 10)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
