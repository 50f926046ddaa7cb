"""Target orbits as terminal rows: given whole, or with elements left free; and the `[target]` table."""
