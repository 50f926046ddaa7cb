"""The indirect method: extremals of Pontryagin's principle, and Newton's method on their initial costates."""
