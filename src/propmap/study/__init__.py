"""Design studies: many blades made from one, at many operating points."""
