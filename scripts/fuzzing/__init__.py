"""What scripts/fuzz.py begins with."""
