"""The CMG cluster: its geometry, momentum, momentum Jacobian, envelope, singularities, and the steering laws."""
