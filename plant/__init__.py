"""The world: soil contact model, single-wheel rig, vehicle, manoeuvres and sensors. Shares no equation with the
estimator."""
