"""The light service (listings 7.9 and 7.10): looks the lights up, listens to each, and answers `on` with `off`."""

import rclpy
from more_interfaces.msg import MqttGatewayOut, SubscriptionData
from more_interfaces.srv import DataRequest, SubscribeTopic
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

NEWEST = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class LightService(Node):
    def __init__(self):
        super().__init__("light_service")
        self.known = {}
        self.publisher_ = self.create_publisher(MqttGatewayOut, "gateway/mqtt/out", 10)
        self.index = self.create_client(DataRequest, "getIndexData")
        while not self.index.wait_for_service(timeout_sec=1.0):
            self.get_logger().info("service not available, waiting again...")
        self.gateway = self.create_client(SubscribeTopic, "subscribe_to_mqtt_topic")

    def ask(self, client, request):
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def find_lights(self):
        request = DataRequest.Request()
        request.servicetype = "lights"
        for entry in self.ask(self.index, request).servicelist:
            topic = entry.elements[1]
            if topic.endswith("/out") and topic not in self.known:
                subscribe = SubscribeTopic.Request()
                subscribe.topic = topic
                answer = self.ask(self.gateway, subscribe)
                self.known[topic] = self.create_subscription(SubscriptionData, answer.data, self.on_data, NEWEST)

    def on_data(self, msg):
        if msg.data == "b'on'":
            self.get_logger().info(f"{msg.topic} is on, turning it off")
            out = MqttGatewayOut()
            out.topic = msg.topic.removesuffix("out") + "in"
            out.data = "off"
            self.publisher_.publish(out)
        elif msg.data == "b'off'":
            self.get_logger().info(f"{msg.topic} is off")


def main(args=None):
    rclpy.init(args=args)
    light_service = LightService()
    while rclpy.ok() and len(light_service.known) < 2:
        light_service.find_lights()
        rclpy.spin_once(light_service, timeout_sec=0.05)
    light_service.get_logger().info(f"light_service knows {len(light_service.known)} lights")
    rclpy.spin(light_service)
    light_service.destroy_node()


if __name__ == "__main__":
    main()
