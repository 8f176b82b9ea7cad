"""What the pixel inspector shows, made in the worker processes that hold the arrays."""
