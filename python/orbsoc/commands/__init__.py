"""The commands of `orbsoc`, one module each; orbsoc.commands.app registers them."""
