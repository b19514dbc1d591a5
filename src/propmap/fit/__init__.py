"""Section parameters from measured loads and from flight (the paper's section III)."""
