"""What is kept on disk and who computes it: keys, whole files, folders, workers, resuming."""
