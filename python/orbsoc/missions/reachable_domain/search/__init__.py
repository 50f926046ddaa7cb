"""From one plane to the whole domain, and what can be asked of it."""
