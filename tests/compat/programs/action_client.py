import rclpy
from action_msgs.msg import GoalStatus
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient
from rclpy.node import Node


class FibonacciActionClient(Node):
    def __init__(self):
        super().__init__("fibonacci_action_client")
        self._action_client = ActionClient(self, Fibonacci, "fibonacci")
        self.heard = 0

    def send_goal(self, order):
        goal_msg = Fibonacci.Goal()
        goal_msg.order = order
        self._action_client.wait_for_server()
        self._send_goal_future = self._action_client.send_goal_async(goal_msg, feedback_callback=self.feedback_callback)
        self._send_goal_future.add_done_callback(self.goal_response_callback)

    def goal_response_callback(self, future):
        self.goal_handle = future.result()
        if not self.goal_handle.accepted:
            self.get_logger().info("Goal rejected :(")
            return
        self.get_logger().info("Goal accepted :)")
        self._get_result_future = self.goal_handle.get_result_async()
        self._get_result_future.add_done_callback(self.get_result_callback)

    def get_result_callback(self, future):
        outcome = future.result()
        if outcome.status == GoalStatus.STATUS_SUCCEEDED:
            self.get_logger().info(f"Result: {outcome.result.sequence} after {self.heard} feedbacks")
            self.send_goal(1000)  # for ever: it is cancelled after its first feedback
            return
        self.get_logger().info(f"Status: {outcome.status}")
        rclpy.shutdown()

    def feedback_callback(self, feedback_msg):
        self.heard += 1
        self.get_logger().info(f"Received feedback: {feedback_msg.feedback.sequence}")
        if self.heard > 9:  # the first of them may come before the goal is known to be accepted
            self.goal_handle.cancel_goal_async()


def main(args=None):
    rclpy.init(args=args)
    action_client = FibonacciActionClient()
    action_client.send_goal(10)
    rclpy.spin(action_client)


if __name__ == "__main__":
    main()
