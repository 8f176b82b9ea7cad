"""How fast minirt is, beside others, as `make bench` measured it last: `speed.json`."""
