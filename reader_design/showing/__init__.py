"""Every figure, drawn without global state in one style."""
