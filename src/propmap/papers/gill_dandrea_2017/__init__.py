"""The paper's results from its own ingredients and public data: numbers, figures, one page.

``numbers`` of each part are computed by the modules here, drawn and told in ``pages``.
"""
