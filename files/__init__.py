"""Files on disk: TOML in, JSON out, the cache folder and the data of the package."""
