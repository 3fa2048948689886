"""Runs on a cluster: job scripts for Slurm, sending them, and how far a run is."""
