"""Drives of robots as files of other programs: MCAP with ROS 2 messages, TUM, CSV."""
