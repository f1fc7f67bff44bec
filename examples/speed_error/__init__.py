"""The parts of examples/speed_against_error: runs, judgement, tables and plots."""
