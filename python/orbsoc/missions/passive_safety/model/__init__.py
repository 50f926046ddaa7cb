"""The mission's mathematics: the approach in (R, T, N), margins for errors, and the conic problem of given times."""
