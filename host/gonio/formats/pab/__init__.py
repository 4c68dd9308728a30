"""pab text: what pab goniophotometers write and Radiance's pabopto2bsdf reads."""
