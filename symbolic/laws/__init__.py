"""Force laws of a wheel, one file each."""
