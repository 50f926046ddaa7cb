"""From the paper's rules by shooting to the impulses that cost least, by cones."""
