import rclpy
import rclpy.node
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult


class MinimalParam(rclpy.node.Node):
    def __init__(self):
        super().__init__("minimal_param_node")
        description = ParameterDescriptor(description="This parameter is mine!")
        self.declare_parameter("my_parameter", "world", description)
        self.add_on_set_parameters_callback(self.check)
        self.timer = self.create_timer(0.05, self.timer_callback)

    def check(self, params):
        for param in params:
            if param.name == "my_parameter" and not param.value:
                return SetParametersResult(successful=False, reason="an empty name")
        return SetParametersResult(successful=True)

    def timer_callback(self):
        my_param = self.get_parameter("my_parameter").get_parameter_value().string_value
        self.get_logger().info(f"Hello {my_param}!")
        for name in ("", "moon" if my_param == "world" else "world"):
            my_new_param = rclpy.parameter.Parameter("my_parameter", rclpy.Parameter.Type.STRING, name)
            (result,) = self.set_parameters([my_new_param])
            if not result.successful:
                self.get_logger().info(result.reason)


def main():
    rclpy.init()
    node = MinimalParam()
    rclpy.spin(node)


if __name__ == "__main__":
    main()
