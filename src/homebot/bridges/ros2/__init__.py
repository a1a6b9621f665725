"""The bridge to ROS 2 robots, over Zenoh in the layout of ``rmw_zenoh``: topics, services and nodes of both sides."""
