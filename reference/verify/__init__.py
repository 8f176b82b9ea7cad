"""Compare minirt with references, scene by scene: options, records of the results, and the run."""
