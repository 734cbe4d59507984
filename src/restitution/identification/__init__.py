"""Materials from measured impacts, indentations and moduli."""
