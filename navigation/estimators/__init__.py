"""Estimators of the robot's pose: Kalman filters, particle filter, fingerprints, SLAM."""
