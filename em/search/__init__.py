"""Candidates for paths: the complete image search, ways over edges, launched rays."""
