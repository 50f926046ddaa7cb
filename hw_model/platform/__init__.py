"""The computer as tagged parameters: devices, presets, partitions, units' latencies."""
