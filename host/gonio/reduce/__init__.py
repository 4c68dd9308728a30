"""reduce: from the raw log to a BSDF dataset."""
