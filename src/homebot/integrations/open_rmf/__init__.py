"""Open-RMF: lifts for the robots of a fleet.

Reads: the floor and the door of a lift, or of another device that takes a floor: a choice, a number, or a motor of two
ends, as of a stair lift or of one in a garage. ``/lift_states`` has them once a second.

Commands: requests of robots on ``/adapter_lift_requests``, or ``/lift_requests`` beside a lift supervisor, one session
after the other: the lift goes to the floor with its door closed, and both are held for the session.

Transport: topics of the graph, which robots reach by rosbridge or Zenoh; the app ``rmf_lift`` (``homebot.apps``).

Source: ``rmf_lift_msgs`` of rmf_internal_msgs, and ``lift_supervisor`` of rmf_ros2, github.com/open-rmf.

Tested against: the type hashes that ROS 2 generates, and simulated lifts and robots.

Not done: lifts of several cars, and the modes for fire and emergency. It has no simulated devices.
"""
