"""The report: what results files hold, as figures, tables and one page."""
