"""Independent flights of a programme: the linear equations by DOP853 with bounds, cut burns, aborts, and about the Earth."""
