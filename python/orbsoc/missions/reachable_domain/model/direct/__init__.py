"""The direct method: condensed convex subproblems on Legendre–Gauss nodes, and the sequences that solve them."""
