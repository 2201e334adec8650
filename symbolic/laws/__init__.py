"""Force laws of a wheel, one file each: `LAW` of every module without a leading underscore is one."""
