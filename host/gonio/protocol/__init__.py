"""The wire: frames, messages and packed records (the generated code is made by make)."""
