"""Outside the virtual machine: rig files, boots, results, outcomes."""
