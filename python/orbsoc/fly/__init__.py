"""Missions flown in a closed loop, on a computer whose time counts: one flight or many, at this computer's speed and others."""
