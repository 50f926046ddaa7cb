"""From an approach to its impulses: convex problems in sequence, on one side of the keep-out and the other."""
