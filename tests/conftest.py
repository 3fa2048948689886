"""What all tests share."""

from __future__ import annotations

import os

import pytest
from hypothesis import Phase, settings

# For scripts/mutate.py: that a test fails is enough; it need not find the smallest example.
settings.register_profile("any-failure", phases=(Phase.explicit, Phase.generate))


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Fails a run in which more tests were skipped than TBI_MAX_SKIPS allows: none goes unnoticed."""
    allowed = os.environ.get("TBI_MAX_SKIPS")
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if allowed is None or reporter is None or hasattr(session.config, "workerinput"):
        return
    skipped = len(reporter.stats.get("skipped", []))
    if skipped > int(allowed):
        reporter.write_line(f"{skipped} tests were skipped; TBI_MAX_SKIPS allows {allowed}", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED
