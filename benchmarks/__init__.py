"""Benchmarks, for asv; README.md tells how to run them."""
