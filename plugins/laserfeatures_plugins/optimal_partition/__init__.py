"""Optimal partition: the whole scan explained with no line proposed."""

from laserfeatures_plugins.optimal_partition.detector import OptimalPartition

__all__ = ["OptimalPartition"]
