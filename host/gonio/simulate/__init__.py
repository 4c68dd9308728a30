"""simulate: what an ideal sample would show the instrument."""
