"""lobes: Gaussian lobes of one measured distribution, found and fitted from strong to weak."""
