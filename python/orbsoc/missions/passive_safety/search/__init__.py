"""When the impulses are: times given, scanned or generated, and what other durations would cost."""
