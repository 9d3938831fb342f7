"""Trajectory tracking from RSS: the controllers of thesis chapters 6 and 7 and modern peers."""
