"""From a scenario to its burn: strategies in their order, the attempts that they make, and what may be claimed of these."""
