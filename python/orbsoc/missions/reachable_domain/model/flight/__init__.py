"""Flights of attitude programmes by an independent integrator, and the orbits that they reach.

A programme is vectors at Legendre–Gauss nodes whose interpolant, normalised, is the thrust direction: the unit controls of a
convex sequence, or primer vectors at their own lengths.
"""
