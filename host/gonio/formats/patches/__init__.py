"""patches: averages of a scattering function over pairs of Klems patches, by adaptive cubature."""
