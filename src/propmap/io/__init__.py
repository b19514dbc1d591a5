"""Propeller geometry and other files: readers, one file per format, and safe writing.

A reader of a geometry is ``read_X(path, blades=None, radius=None) -> Propeller``.  ``blades``
replaces the number of blades in the file; ``radius`` [m] scales a file that gives fractions of
it, and must agree with a file that has a radius of its own.  Whatever is wrong with the file,
the readers raise ``propmap.errors.InputError`` and nothing else.
"""
