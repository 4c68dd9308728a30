"""merge: datasets of one sample as one: joined points, overlap and seam statistics, retro rig, repeatability."""
