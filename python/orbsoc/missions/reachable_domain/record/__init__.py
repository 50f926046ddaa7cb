"""The files of a solved domain: shards, tables, summary, report, CCSDS messages."""
