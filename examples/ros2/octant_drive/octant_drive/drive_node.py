"""Octant's navigator as a node. NOT TESTED: needs ROS 2.

Listens to ``/odom`` and ``/rss_w``; each reading is a tick of the loop, whose command goes out on
``/cmd_vel``, with the wanted tag on ``/target_tag`` and what the robot does on ``/state``.
"""

import rclpy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_msgs.msg import Bool, Float64MultiArray, String

from .loop import DriveLoop, mission_of, yaw_rad


class DriveNode(Node):
    """Drives the robot through the mission of a study."""

    def __init__(self) -> None:
        super().__init__("octant_drive")
        study = self.declare_parameter("study", "office").value
        seed = self.declare_parameter("seed", 1).value
        self._loop = DriveLoop(mission_of(study), seed=seed)
        self._pose, self._contact, self._done = None, False, False
        self._commands = self.create_publisher(Twist, "cmd_vel", 10)
        self._tags = self.create_publisher(String, "target_tag", 10)
        self._states = self.create_publisher(String, "state", 10)
        self.create_subscription(Odometry, "odom", self._moved, 10)
        self.create_subscription(Bool, "contact", self._touched, 10)
        self.create_subscription(Float64MultiArray, "rss_w", self._heard, 10)
        self.create_timer(1.0, self._say_tag)

    def _moved(self, message: Odometry) -> None:
        place, turn = message.pose.pose.position, message.pose.pose.orientation
        self._pose = (place.x, place.y, yaw_rad(turn.x, turn.y, turn.z, turn.w))

    def _touched(self, message: Bool) -> None:
        self._contact = self._contact or message.data

    def _say_tag(self) -> None:
        self._tags.publish(String(data=self._loop.pilot.tag_id))

    def _heard(self, message: Float64MultiArray) -> None:
        if self._pose is None or self._done:
            return
        wanted = self._loop.tick(message.data, self._pose, contact=self._contact)
        self._contact, self._done = False, wanted.done
        command = Twist()
        command.linear.x = wanted.speed_m_per_s
        command.angular.z = wanted.turn_rate_rad_per_s
        self._commands.publish(command)
        self._states.publish(String(data=wanted.state))
        if wanted.reached is not None:
            self.get_logger().info(f"tag {wanted.reached} is reached")
            self._say_tag()


def main() -> None:
    """Run the node."""
    rclpy.init()
    rclpy.spin(DriveNode())


if __name__ == "__main__":
    main()
