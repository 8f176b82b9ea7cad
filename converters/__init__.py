"""A scene or a frame in somebody else's language: data in, data out."""
