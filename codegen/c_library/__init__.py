"""A model and its filter as a C library that stands on its own: what `softsoil generate` writes."""
