"""Octant in a robot: the loop without ROS, and its nodes."""
