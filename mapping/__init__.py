"""Maps of the soil: n along the way of drives, per cell of the ground."""
