"""Diagnose a failing implementation: which known mistake explains its errors."""
