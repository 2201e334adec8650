"""Force laws of a wheel, one file each: every module without a leading underscore is one, its class called as the file."""
