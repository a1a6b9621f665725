"""The index (listings 7.6 to 7.8): the addresses of each service type, by the topics that the gateway hears."""

import rclpy
from more_interfaces.msg import MqttGatewayIn, StringList
from more_interfaces.srv import DataRequest
from rclpy.node import Node


class DiscoveryManager(Node):
    def __init__(self):
        super().__init__("discovery_manager")
        self.index = {}
        self.subscription = self.create_subscription(
            MqttGatewayIn, "gateway/mqtt/received_topics", self.listener_callback, 10
        )
        self.srv = self.create_service(DataRequest, "getIndexData", self.get_index_data)

    def listener_callback(self, msg):
        servicetype = msg.data.split("/")[1]
        entries = self.index.setdefault(servicetype, [])
        if (msg.gateway, msg.data) not in entries:
            entries.append((msg.gateway, msg.data))
            self.get_logger().info(f"{servicetype}: {msg.data} at {msg.gateway}")

    def get_index_data(self, request, response):
        for entry in self.index.get(request.servicetype, []):
            element = StringList()
            element.elements = list(entry)
            response.servicelist.append(element)
        return response


def main(args=None):
    rclpy.init(args=args)
    discovery_manager = DiscoveryManager()
    rclpy.spin(discovery_manager)
    discovery_manager.destroy_node()


if __name__ == "__main__":
    main()
