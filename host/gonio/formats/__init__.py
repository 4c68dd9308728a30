"""File formats for BSDF data: one module each, plus the validator."""
