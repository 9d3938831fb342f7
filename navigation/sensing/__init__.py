"""What the robot senses: RSS, bearings, landmarks."""
