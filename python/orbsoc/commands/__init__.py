"""The commands of `orbsoc`, one module each; orbsoc.cli registers them."""
