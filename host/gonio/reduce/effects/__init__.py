"""effects: what all points share: one sensitivity column per systematic effect (GUM)."""
