"""Embree, through its Python binding; trimesh's own engine in its place."""
