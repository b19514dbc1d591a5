"""Section constants of all propellers of the UIUC database, and their distribution.

``python -m tools.catalogue`` identifies the constants.  ``python -m tools.catalogue.left_out``
predicts each propeller from the others and prints the errors.
"""
