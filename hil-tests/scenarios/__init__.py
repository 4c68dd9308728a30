"""What the rig goes through: one module per group of scenarios, each a function of its steps."""
