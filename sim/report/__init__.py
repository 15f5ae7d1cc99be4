"""The report of a run: one offline HTML file, floor plans as pictures, a terminal table."""

from sim.report.data import ReportData
from sim.report.page import render_report, write_report
from sim.report.table import result_table, result_title

__all__ = ["ReportData", "render_report", "result_table", "result_title", "write_report"]
