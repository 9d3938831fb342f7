"""Candidates for paths: the complete image search, routes over edges, launched rays."""
