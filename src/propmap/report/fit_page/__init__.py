"""The page on a fit: verdict, data, errors, parameters, load curves, further data."""
