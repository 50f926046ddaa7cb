"""The insertion flown in a closed loop: the vehicle as it is, guidance that plans again, and what is done when thrust is lost."""
