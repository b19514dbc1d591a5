"""Section constants of all propellers of the UIUC database, and how they are spread over them.

``python -m tools.catalogue`` finds them, ``python -m tools.catalogue.left_out`` says how well they
predict propellers that were left out.
"""
