"""The truth of real scans."""
