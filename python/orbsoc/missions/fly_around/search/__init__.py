"""How many pulses, and when: the proof that fewer cannot do, and the search for a programme within the tube."""
