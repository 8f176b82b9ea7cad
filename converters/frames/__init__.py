"""Frames in files: NumPy archives, OpenEXR, folders of single images."""
