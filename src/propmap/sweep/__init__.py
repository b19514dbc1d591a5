"""Sweeps of any size: operating points in tasks, their loads streamed into one Zarr store."""
