"""The only files that import or start a renderer."""
