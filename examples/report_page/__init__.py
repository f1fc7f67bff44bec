"""The parts of the page that examples/report.py writes."""
