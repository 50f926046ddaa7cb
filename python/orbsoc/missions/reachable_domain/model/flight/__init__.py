"""Attitude programmes, their propagation by an independent integrator, and the orbits that they reach."""
