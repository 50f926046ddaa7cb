"""Answers from timelines: reports, explanations, sweeps, traces for viewers."""
