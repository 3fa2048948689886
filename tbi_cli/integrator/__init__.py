"""The integrator: it knows arrays, not trains.  Importing it settles where compiled kernels are kept."""

from tbi_cli.integrator import kernel_cache as _kernel_cache

_kernel_cache.settle()
