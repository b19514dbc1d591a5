"""Tools that write the catalogue, the tables of README and the generated parts of the docs."""
