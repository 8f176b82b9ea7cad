"""Another author's implementation, judged as a reference is. It sees scenes, never our frames."""
