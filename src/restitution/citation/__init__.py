"""What to cite: the sources of the methods, materials and profiles that a problem uses."""
