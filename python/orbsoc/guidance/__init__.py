"""What every mission shares: scenario files, collocation, sequential convex programming."""
