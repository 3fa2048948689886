"""Independent solutions that the solver is compared with.

Nothing here imports the solver (`tbi_cli.system`, `tbi_cli.integrator`, ...): every module starts again
from the paper's energies, from a modal equation written out by hand, or from a closed form, and
integrates where it must with scipy's DOP853. A slip in the solver therefore cannot repeat itself here.
"""
