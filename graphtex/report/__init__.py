"""The report of a run: one HTML file with the drawn graph, and what every task was given and made."""

from graphtex.report.build import report_html, write_report

__all__ = ["report_html", "write_report"]
