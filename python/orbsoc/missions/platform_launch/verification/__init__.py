"""Flights of the plan about a round and an oblate Earth, and what an engine failure does to it."""
