"""What writes the catalogue, the tables of README and the generated parts of the documentation."""
