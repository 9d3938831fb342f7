"""The robot, its sensing and controllers, closed-loop missions and their metrics."""
