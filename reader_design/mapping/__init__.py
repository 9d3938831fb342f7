"""What a robot is told that knows its room: field maps of the tags, and the filter of its pose."""
