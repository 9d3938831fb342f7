"""The study file: its schema, its checks, and the study with every default resolved."""
