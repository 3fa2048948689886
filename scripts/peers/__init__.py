"""Other ways to compute the same crossing, for scripts/benchmark.py to compare with."""
