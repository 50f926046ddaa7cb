"""The plan as files: `plan.json`, OEM and OPM."""
