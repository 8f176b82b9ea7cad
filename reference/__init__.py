"""Whom minirt is compared with, and how."""
