"""The simulated platform. The only room with MuJoCo."""
