"""ROS ``example_interfaces``: the service of its tutorials."""

from homebot.messages.message import Message, ServiceType

__all__ = ["AddTwoInts", "AddTwoIntsRequest", "AddTwoIntsResponse"]


class AddTwoIntsRequest(Message, ros_type="example_interfaces/srv/AddTwoInts_Request"):
    """Two whole numbers to add."""

    a: int
    b: int


class AddTwoIntsResponse(Message, ros_type="example_interfaces/srv/AddTwoInts_Response"):
    """Their sum."""

    sum: int


AddTwoInts = ServiceType("example_interfaces/srv/AddTwoInts", AddTwoIntsRequest, AddTwoIntsResponse)
