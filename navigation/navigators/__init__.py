"""Navigators: what decides, from readings and odometry alone, how the wheels turn."""
