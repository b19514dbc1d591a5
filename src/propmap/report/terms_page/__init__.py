"""The page on what each term of a flight fit is worth."""
