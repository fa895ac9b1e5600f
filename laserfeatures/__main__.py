"""``python -m laserfeatures`` is the command ``laserfeatures``."""

from laserfeatures.cli import main

if __name__ == "__main__":
    main()
