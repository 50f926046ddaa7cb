"""Events, durations and precedence of a recorded solve: its timeline."""
