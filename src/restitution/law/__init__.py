"""A contact law with memory for codes that step in time."""
