"""The tracking study: thesis chapters 6 and 7 recomputed, chapter by chapter."""
