"""The track: how level its two rails are, along the approaches and the bridge."""

from tbi_cli.track.profile import RailProfile
from tbi_cli.track.rails import rail_profile
from tbi_cli.track.spectra import SPECTRA, Spectrum

__all__ = ["SPECTRA", "RailProfile", "Spectrum", "rail_profile"]
