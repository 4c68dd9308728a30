"""corrections: what is taken off or divided out, in order; each can be switched off and is recorded."""
