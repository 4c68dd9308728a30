"""The virtual machine's kernel."""
