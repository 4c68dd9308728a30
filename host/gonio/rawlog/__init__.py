"""The raw log: what came over the link, unprocessed, in MCAP files."""
