"""Embree, through its Python binding; without that, trimesh's own engine."""
