"""The blind proof of the diagnosis: scripts/prove."""
