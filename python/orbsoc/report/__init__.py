"""The output of a planning run: data, tables, figures, and one page."""
