"""RoboTHOR's apartments and episodes, rebuilt from public metadata (README.md beside this)."""
