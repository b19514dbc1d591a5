"""What is modelled: propeller, blade section, air."""
