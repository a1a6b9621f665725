import rclpy
from rclpy.node import Node
from rclpy.qos import QoSPresetProfiles
from rclpy.subscription import Subscription
from std_msgs.msg import String


class MinimalSubscriber(Node):
    def __init__(self):
        super().__init__("minimal_subscriber")
        profile = QoSPresetProfiles.SENSOR_DATA.value
        self.subscription: Subscription = self.create_subscription(String, "topic", self.listener_callback, profile)

    def listener_callback(self, msg):
        self.get_logger().info(f'I heard: "{msg.data}"')


def main(args=None):
    rclpy.init(args=args)
    minimal_subscriber = MinimalSubscriber()
    rclpy.spin(minimal_subscriber)
    minimal_subscriber.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
