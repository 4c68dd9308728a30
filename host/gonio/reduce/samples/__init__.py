"""samples: from the raw log to samples with pose, time and light, path by path."""
