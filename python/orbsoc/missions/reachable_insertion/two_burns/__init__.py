"""Burn, coast, burn: targets that no single burn reaches, or that two reach with less propellant."""
