"""The robot on its floor: drive, wheels, odometry, contact."""
