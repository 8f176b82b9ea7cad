"""The gate for other implementations, beyond its command."""
