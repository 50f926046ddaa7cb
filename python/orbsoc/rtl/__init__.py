"""Run schedules and whole solves on the RTL under Verilator, and compare every word and cycle."""
