"""Readers of propeller geometry and other files, and safe writing of files.

A geometry reader is ``read_X(path, blades=None, radius=None) -> Propeller``.  ``blades`` replaces
the number of blades in the file.  ``radius`` [m] scales a file with fractions of the radius.  In
other files it must agree with the radius of the file.  Readers raise only
``propmap.errors.InputError``.
"""
