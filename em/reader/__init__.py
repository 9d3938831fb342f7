"""The reader's response: embedded patterns by full wave, by rays, isolated, or from files."""
