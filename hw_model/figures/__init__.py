"""Pictures of modelled time and area."""
