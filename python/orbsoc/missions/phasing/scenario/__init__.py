"""What a scenario file may say: its keys and checks, and chaser and target in any form of the orbit table."""

from .keys import Body, Engine, Errors, Limits, Scenario, Surprise, Window, load_scenario
from .orbits import zero_utc

__all__ = [
    "Body",
    "Engine",
    "Errors",
    "Limits",
    "Scenario",
    "Surprise",
    "Window",
    "load_scenario",
    "zero_utc",
]
