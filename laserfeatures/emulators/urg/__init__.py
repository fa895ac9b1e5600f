"""Hokuyo URG-04LX-UG01 and URG-04LX, emulated."""

from laserfeatures.emulators.urg.device import STATES, TROUBLES, UrgDevice
from laserfeatures.emulators.urg.models import MODELS, Model

__all__ = ["MODELS", "STATES", "TROUBLES", "Model", "UrgDevice"]
