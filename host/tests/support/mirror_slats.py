"""mirror_slats.py: a blind whose whole answer is known: flat horizontal slats, above a mirror, below black; no
deeper than they are apart."""

SLATS = """
[sample]
kind = "blind"
count = 101
length_mm = 2000.0
top = "shiny"
bottom = "dark"
[materials.shiny]
kind = "mirror"
reflectance = 0.7
[materials.dark]
kind = "black"
"""
