"""Energy of a modelled run: counted actions times what each costs."""
