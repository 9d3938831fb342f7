"""Exact paths: every vertex inside its facet, every segment free."""
