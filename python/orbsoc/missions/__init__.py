"""Missions: one folder per paper, each a scenario, a model, a plan, its figures.

Every mission package has the same face: `Scenario`, `plan(scenario, *, solve=…) -> Plan`. A mission builds conic
problems and hands them to whatever `solve` it is given; it knows no registers, cycles or partitions.
"""
