"""The renderers that minirt is compared with, and how it is compared."""
