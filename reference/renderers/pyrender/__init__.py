"""pyrender, a rasteriser."""
