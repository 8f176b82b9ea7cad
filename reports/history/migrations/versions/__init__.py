"""The steps, linked by their `down_revision`."""
