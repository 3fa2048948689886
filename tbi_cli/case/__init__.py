"""Case files: YAML with units to a validated, frozen case in SI."""

from tbi_cli.case.axes import SHORT_NAMES, Axis
from tbi_cli.case.axle_forces import HSLM_A, AxleForces, HslmA
from tbi_cli.case.bridge import Beam, Bridge, Damping
from tbi_cli.case.builtin import Builtin, list_builtin
from tbi_cli.case.consist import Consist, Vehicles
from tbi_cli.case.document import ExtraAxis
from tbi_cli.case.full_train import BogieEnd, FullTrain, Suspension
from tbi_cli.case.geometry import Geometry
from tbi_cli.case.load import load_case
from tbi_cli.case.messages import CaseError, RunError
from tbi_cli.case.model import Case
from tbi_cli.case.settings import Contact, Histories, Output, Solver
from tbi_cli.case.simple_vehicles import MovingLoad, RigidBeam, SprungMass
from tbi_cli.case.starter import starter_case
from tbi_cli.case.track import Dip, HalfSine, Harmonic, Irregularity, Profile, Ramp, Random, Track
from tbi_cli.case.train import Train

__all__ = [
    "HSLM_A",
    "SHORT_NAMES",
    "Axis",
    "AxleForces",
    "Beam",
    "BogieEnd",
    "Bridge",
    "Builtin",
    "Case",
    "CaseError",
    "Consist",
    "Contact",
    "Damping",
    "Dip",
    "ExtraAxis",
    "FullTrain",
    "Geometry",
    "HalfSine",
    "Harmonic",
    "Histories",
    "HslmA",
    "Irregularity",
    "MovingLoad",
    "Output",
    "Profile",
    "Ramp",
    "Random",
    "RigidBeam",
    "RunError",
    "Solver",
    "SprungMass",
    "Suspension",
    "Track",
    "Train",
    "Vehicles",
    "list_builtin",
    "load_case",
    "starter_case",
]
