"""Drives on disk, as MCAP: written beside the loop, read back for replay and benchmarks."""
