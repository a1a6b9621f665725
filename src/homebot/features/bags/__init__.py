"""Bags: messages of topics in MCAP files, as rosbag2 of ROS 2 writes and reads them."""
