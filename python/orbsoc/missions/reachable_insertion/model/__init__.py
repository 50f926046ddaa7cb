"""The mathematics of a burn: its convex problems, the turn of its thrust, coasts, and bounds that no burn escapes."""
