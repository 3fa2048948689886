"""Results on disk: written batch by batch so that nothing is lost, read as one labelled grid."""

from tbi_cli.store.claim import check_output
from tbi_cli.store.errors import StoreError
from tbi_cli.store.layout import DAF, TABLES, Dim, Layout, Variable
from tbi_cli.store.merge import merge
from tbi_cli.store.opening import open_parts, open_results
from tbi_cli.store.provenance import provenance
from tbi_cli.store.records import DONE, FAILED, TO_DO, BatchResult, History
from tbi_cli.store.results import Results
from tbi_cli.store.store import ResultsStore
from tbi_cli.store.studies import StudiesStore, heading_of, studies_of

__all__ = [
    "DAF",
    "DONE",
    "FAILED",
    "TABLES",
    "TO_DO",
    "BatchResult",
    "Dim",
    "History",
    "Layout",
    "Results",
    "ResultsStore",
    "StoreError",
    "StudiesStore",
    "Variable",
    "check_output",
    "heading_of",
    "merge",
    "open_parts",
    "open_results",
    "provenance",
    "studies_of",
]
