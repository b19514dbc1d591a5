"""Reproduction of the results of Gill and D'Andrea (2017) from their model and public data.

``python -m papers.gill_dandrea_2017`` computes the numbers and writes one page from the template
``page.html.j2``.
"""
