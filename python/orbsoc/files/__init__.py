"""Files that are complete or absent, JSON that names what is damaged, interrupts that lose nothing."""
