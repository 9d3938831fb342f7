"""The RSS sensor of a simulated robot. NOT TESTED: needs ROS 2.

Listens to the robot's true pose in the room (``/ground_truth/odom``) and to the tag that is wanted
(``/target_tag``); publishes readings of all antennas on ``/rss_w`` [W].
"""

import rclpy
from nav_msgs.msg import Odometry
from rclpy.node import Node
from std_msgs.msg import Float64MultiArray, MultiArrayDimension, String

from .loop import mission_of, yaw_rad


class RssNode(Node):
    """Reads the wanted tag once a period at the robot's true pose."""

    def __init__(self) -> None:
        super().__init__("octant_rss")
        study = self.declare_parameter("study", "office").value
        seed = self.declare_parameter("seed", 1).value
        pilot, self._reader = mission_of(study).pilot(seed=seed, progress=False)
        self._tag, self._truth = pilot.tag_id, None
        self._readings = self.create_publisher(Float64MultiArray, "rss_w", 10)
        self.create_subscription(Odometry, "ground_truth/odom", self._moved, 10)
        self.create_subscription(String, "target_tag", self._wanted, 10)
        self.create_timer(pilot.period_s, self._read)

    def _moved(self, message: Odometry) -> None:
        self._truth = message

    def _wanted(self, message: String) -> None:
        if message.data in self._reader.tag_ids:
            self._tag = message.data

    def _read(self) -> None:
        if self._truth is None:
            return
        place, turn = self._truth.pose.pose.position, self._truth.pose.pose.orientation
        twist = self._truth.twist.twist
        rss_w = self._reader.read(
            (place.x, place.y, yaw_rad(turn.x, turn.y, turn.z, turn.w)),
            self._tag,
            speed_m_per_s=twist.linear.x,
            turn_rate_rad_per_s=twist.angular.z,
        )
        message = Float64MultiArray(data=rss_w.tolist())
        count = len(rss_w)
        message.layout.dim = [MultiArrayDimension(label="antenna", size=count, stride=count)]
        self._readings.publish(message)


def main() -> None:
    """Run the node."""
    rclpy.init()
    rclpy.spin(RssNode())


if __name__ == "__main__":
    main()
