"""Numbers that others have published, beside what this computes: `orbsoc reproduce accuracy`."""
