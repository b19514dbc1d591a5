"""The results of Gill and D'Andrea (2017) from its own ingredients and public data, on one page.

``python -m papers.gill_dandrea_2017`` computes the numbers and writes the page; its words are in
``page.html.j2``.
"""
