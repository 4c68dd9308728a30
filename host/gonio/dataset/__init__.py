"""dataset: the BSDF dataset in memory and in HDF5 (NeXus)."""
