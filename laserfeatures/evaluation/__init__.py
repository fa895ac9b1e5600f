"""What is true of a scan, the best that could be found in it, and scores of what was found."""

from laserfeatures.evaluation.matching import match_corners, match_lines
from laserfeatures.evaluation.oracle import oracle
from laserfeatures.evaluation.scores import Score, score
from laserfeatures.evaluation.truth import Truth, truth_of

__all__ = ["Score", "Truth", "match_corners", "match_lines", "oracle", "score", "truth_of"]
