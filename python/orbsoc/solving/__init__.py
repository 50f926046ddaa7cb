"""Solve one problem, or many of one sparsity pattern, with the Rust core."""
