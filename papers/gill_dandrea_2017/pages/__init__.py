"""The page: figures, tables and CSV files of each part; the words are in ``page.html.j2``."""
