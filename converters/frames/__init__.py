"""Frames in files: NumPy archives, OpenEXR, folders of single images; `io.py` is the door."""
