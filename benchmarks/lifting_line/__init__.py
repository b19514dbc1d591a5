"""An unsteady lifting line of a rigid propeller in oblique flow, to compare inflow theories with.

It takes the propeller's geometry and the section law from the package, and nothing of its inflow:
what the air does at a blade comes from the vortices of the wake by Biot and Savart's law.
`make bench ONLY=lifting_line` runs it.
"""
