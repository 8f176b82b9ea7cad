"""Which pairs of a ray and a primitive are worth asking; never changes an answer."""
