"""Marks for a class: every submission through the gate, points by a rubric, a page a student."""
