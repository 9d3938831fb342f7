"""Materials, antennas, paths, fields, radio maps and the reader's response."""
