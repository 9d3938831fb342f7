"""Measured readings: logs compared with the model, studies fitted to them, drives replayed."""
