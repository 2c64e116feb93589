"""Bags of ROS 1 and ROS 2, and MCAP files, without a ROS installation."""
