"""A scene as glTF 2.0."""
