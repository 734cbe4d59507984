"""Many impacts over named axes, in memory or in a store."""
