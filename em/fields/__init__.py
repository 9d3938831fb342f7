"""Vector fields along paths, polarisation and every interaction included."""
