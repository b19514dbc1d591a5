"""Design studies: many designs derived from one propeller, at many operating points."""
