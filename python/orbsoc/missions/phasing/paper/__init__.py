"""What the paper prints, beside what is found here."""
