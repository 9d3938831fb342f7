"""What a navigator of one's own is written with."""

from octant.navigation.navigators.interface import Odometry
from octant.navigation.navigators.own import Command, Navigator, Reading

__all__ = ["Command", "Navigator", "Odometry", "Reading"]
