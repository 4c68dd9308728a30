"""What runs inside the virtual machine, beside firmware and twin."""
