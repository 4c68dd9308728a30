"""Between measured incident directions: neighbours, matched lobes, schemes, and which of them leave-one-out chooses."""
