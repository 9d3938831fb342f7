"""Closed-loop missions, their records, metrics and files."""
