"""The verification cases, one module for each group."""

from tbi_cli.verify.cases import (
    balance,
    equations,
    exact_forces,
    force_trains,
    frequencies,
    hertz,
    irregular_rails,
    moving_force,
    order,
    simple_vehicles,
    static_limit,
    stations,
    symmetry,
    trains,
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
        trains,
        exact_forces,
        stations,
    )
)
