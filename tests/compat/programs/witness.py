"""Prints the topics that exist whenever a command is sent."""

import sys

import rclpy
from more_interfaces.msg import MqttGatewayOut
from rclpy.node import Node


def main():
    rclpy.init()
    node = Node("witness")

    def show(msg):
        names = (name for name, _ in node.get_topic_names_and_types())
        sys.stdout.write(" ".join(names) + "\n")  # in one piece: others print at the same time
        sys.stdout.flush()

    node.create_subscription(MqttGatewayOut, "gateway/mqtt/out", show, 10)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
