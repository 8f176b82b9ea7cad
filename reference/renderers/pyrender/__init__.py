"""pyrender, an OpenGL rasteriser."""
