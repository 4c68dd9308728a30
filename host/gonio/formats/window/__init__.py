"""WINDOW XML with Klems matrices: bases, patch averages, reading, writing."""
