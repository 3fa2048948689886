"""Verification: the package's results against closed forms and independent solutions, with tolerances.

Needs scipy and the solver; nothing else in the package imports it but the command `tbi verify`.
"""
