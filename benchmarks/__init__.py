"""Timing of orbsoc beside its peers: problem families, solvers behind one call, interleaved measurement, reports."""
