"""Publications computed again, one folder each."""
