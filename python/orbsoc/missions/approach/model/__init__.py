"""The approach in the frame (R, T, N): its instants, its conditions as rows, and where drifts come nearest."""
