"""Designs, their scores in free space and in the room, the resumable sweep, and the choice."""
