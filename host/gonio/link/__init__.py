"""The session with the controller firmware, over TCP or with a twin in virtual time."""
