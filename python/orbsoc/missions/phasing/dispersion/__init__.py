"""Other drags, errors and cases than the scenario has, and planning again on the way."""
