"""Scenes and frames in the formats of other programs: data in, data out, no renderer."""
