"""Where the search sets out: simple steering, and thrust laws that are flown onto the target orbit."""
