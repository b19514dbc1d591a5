"""Section laws: lift and drag of a blade section, one file per law."""
