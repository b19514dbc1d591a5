"""Identification of section constants from measured loads and from flights (section III)."""
