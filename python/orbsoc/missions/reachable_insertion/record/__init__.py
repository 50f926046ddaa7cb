"""A plan as files: the document behind `plan.json`, the attitude programme, and CCSDS messages."""
