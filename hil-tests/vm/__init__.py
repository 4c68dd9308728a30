"""The small virtual machine: initial root, boot, limits."""
