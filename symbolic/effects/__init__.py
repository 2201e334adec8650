"""Physical effects that a nominal model lacks, one file each: every module without a leading underscore is one."""
