"""solar: what a sample does to sunlight, from channels of known bands and a standard solar spectrum."""
