"""The conic problem: its data, its solution, how either is checked, and their files."""
