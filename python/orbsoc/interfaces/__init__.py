"""Other solvers and modelling languages, behind the shapes of this package."""
