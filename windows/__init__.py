"""Windows of a drive with free initial states, what a model's inputs are along them, and fits to them."""
