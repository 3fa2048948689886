"""All the vehicles that a case file may name under `train: {model: ...}`."""

from __future__ import annotations

from tbi_cli.case.axle_forces import AxleForces, HslmA
from tbi_cli.case.consist import Consist
from tbi_cli.case.full_train import FullTrain
from tbi_cli.case.part import Part
from tbi_cli.case.simple_vehicles import MovingLoad, RigidBeam, SprungMass

Train = FullTrain | SprungMass | RigidBeam | MovingLoad | AxleForces | HslmA | Consist
TRAINS: dict[str, type[Part]] = {
    "full-31dof": FullTrain,
    "sprung-mass": SprungMass,
    "rigid-beam": RigidBeam,
    "moving-load": MovingLoad,
    "axle-forces": AxleForces,
    "hslm-a": HslmA,
    "consist": Consist,
}
# Those of which a consist can be made.
VEHICLES = {model: part for model, part in TRAINS.items() if part is not Consist}
