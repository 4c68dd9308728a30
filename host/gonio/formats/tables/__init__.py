"""Tables of points: CSV, and the BRDF tables that NIST publishes."""
