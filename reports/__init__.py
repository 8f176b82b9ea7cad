"""All that a person or a CI system sees."""
