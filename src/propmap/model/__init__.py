"""The model of a rotor: propeller, section law, air and corrections."""
