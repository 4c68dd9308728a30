"""Reports: a dataset as one self-contained HTML file and as a summary in JSON."""
