"""What a results file holds of a crossing."""

from tbi_cli.responses.channel import Channel, Signal
from tbi_cli.responses.train import channels

__all__ = ["Channel", "Signal", "channels"]
