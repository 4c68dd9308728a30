"""Commissioning of CiA 402 drives over any python-can interface: find, check, load, store. Never enables a motor."""
