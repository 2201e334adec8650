"""The declaration of a model: vehicle, soil, force law and effects in one TOML file."""
