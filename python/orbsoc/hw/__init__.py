"""Price a recorded solve on the emulated computer: workloads, schedules, budgets, deadlines."""
