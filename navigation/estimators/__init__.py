"""State estimators: Kalman filters and what judges them."""
