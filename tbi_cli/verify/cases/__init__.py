"""The verification cases, one module for each group."""

from tbi_cli.verify.cases import (
    balance,
    equations,
    force_trains,
    frequencies,
    hertz,
    irregular_rails,
    moving_force,
    order,
    simple_vehicles,
    static_limit,
    symmetry,
    whole_crossing,
)

VERIFICATIONS = tuple(
    module.VERIFICATION
    for module in (
        simple_vehicles,
        moving_force,
        force_trains,
        static_limit,
        frequencies,
        balance,
        order,
        symmetry,
        equations,
        whole_crossing,
        irregular_rails,
        hertz,
    )
)
