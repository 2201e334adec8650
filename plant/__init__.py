"""The simulated world: soil contact, single-wheel rig, vehicle, manoeuvres and sensors, without an equation of the model."""
