"""The simulated reader and the navigator. NOT TESTED: needs ROS 2."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node


def generate_launch_description() -> LaunchDescription:
    """Return both nodes with the study that ``study:=`` names."""
    parameters = [{"study": LaunchConfiguration("study")}]
    return LaunchDescription(
        [
            DeclareLaunchArgument("study", default_value="office"),
            Node(package="octant_drive", executable="rss_node", parameters=parameters),
            Node(package="octant_drive", executable="drive_node", parameters=parameters),
        ]
    )
