"""Work in other processes and on other machines: isolated, watched, cleaned up."""
