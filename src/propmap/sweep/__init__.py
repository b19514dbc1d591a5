"""Sweeps of any size: operating points split into tasks, loads streamed into one Zarr store."""
