"""SLAM on logs and in simulation: trajectories, maps, their errors and pictures."""
