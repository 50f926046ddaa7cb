"""A plan with its verdict and files."""
