"""The extractors that come with laserfeatures, one module each."""
